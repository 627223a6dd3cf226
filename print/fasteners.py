"""The screws and bearings that a body's parts hold, counted once each."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array
from morph.print.bearing import BEARINGS
from morph.print.part import Part, Placement, Seat
from morph.print.screw import SCREWS
from morph.print.servos import SERVOS

ACROSS_MM = 0.5
"""How far apart two holes' axes may be for one screw to pass through both."""

ALONG_MM = 40.0
"""How far apart along their axis they may be."""


@dataclass(frozen=True, kw_only=True)
class Fastener:
    """A screw or a bearing, how many of it, and for which links."""

    name: str
    """Its name in the catalogue."""
    kind: str
    """`screw` or `bearing`."""
    count: int
    """How many there are in the body."""
    links: tuple[str, ...]
    """The links whose parts hold it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Hole:
    link: str
    cut: bool
    position: Array
    axis: Array


def fasteners(parts: Sequence[Part]) -> tuple[Fastener, ...]:
    """Return every screw and bearing that the seats of parts call for, in the catalogue's order.

    A screw passes through one part and cuts its thread into another: where two such holes lie on
    one line, one screw is counted. A servo's horn takes as many screws as it has holes.
    """
    holes: dict[str, list[_Hole]] = defaultdict(list)
    counted: dict[tuple[str, str], list[str]] = defaultdict(list)
    bearings = {bearing.name for bearing in BEARINGS}
    taps = {screw.name: screw.tap_mm for screw in SCREWS}
    horns = {f"{servo.name} horn": servo.horn for servo in SERVOS}
    for place, seat in _held(parts):
        if seat.holds in bearings:
            counted["bearing", seat.holds].append(place.link)
        elif seat.holds in horns:
            horn = horns[seat.holds]
            counted["screw", horn.screw] += [place.link] * horn.count
        elif seat.holds in taps:
            holes[seat.holds].append(
                _Hole(
                    link=place.link,
                    cut=seat.bore_mm <= taps[seat.holds] + 1e-6,
                    position=place.world[:3, :3] @ seat.position + place.world[:3, 3],
                    axis=place.world[:3, :3] @ seat.axis,
                )
            )
    for screw, result in holes.items():
        counted["screw", screw] += _screws(result)
    return _listed(counted)


def _held(parts: Sequence[Part]) -> Iterator[tuple[Placement, Seat]]:
    """Yield every seat of every copy, and where that copy is."""
    for part in parts:
        yield from itertools.product(part.placements, part.seats)


def _screws(holes: Sequence[_Hole]) -> list[str]:
    """Return a link for each screw: of every hole that is cut into, and of others without one."""
    cut = [hole for hole in holes if hole.cut]
    alone = [hole for hole in holes if not hole.cut and not any(_in_line(hole, to) for to in cut)]
    return [hole.link for hole in (*cut, *alone)]


def _in_line(one: _Hole, other: _Hole) -> bool:
    """Return whether one screw passes through both holes."""
    away = other.position - one.position
    along = float(away @ one.axis)
    across = float(np.linalg.norm(away - along * one.axis))
    parallel = abs(float(one.axis @ other.axis)) > 0.99
    return parallel and across < ACROSS_MM and abs(along) < ALONG_MM


def _listed(counted: Mapping[tuple[str, str], Sequence[str]]) -> tuple[Fastener, ...]:
    known = [("screw", each.name) for each in SCREWS] + [("bearing", one.name) for one in BEARINGS]
    return tuple(
        Fastener(
            name=key[1],
            kind=key[0],
            count=len(counted[key]),
            links=tuple(dict.fromkeys(counted[key])),
        )
        for key in known
        if counted.get(key)
    )
