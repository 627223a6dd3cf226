"""Which part of a target is which part of a source, as a map between them has it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from morph.alignment.maps.body_map import BodyMap
from morph.arrays import Array
from morph.policy_transfer.body import Body

LEAST = 0.1
"""Share of a number from which on an arrow is drawn."""

READINGS = {
    1: ("tilt",),
    2: ("tilt ahead", "tilt aside"),
    4: ("tilt ahead", "tilt aside", "place ahead", "place aside"),
}
"""What is seen of a body by what balancing looks at, by how many numbers those are."""

STEP = 0.05
"""Distance of a finite difference, in spreads."""


@dataclass(frozen=True, kw_only=True)
class Arrow:
    """One number of one body that makes up one number of the other."""

    begin: str
    """Where it begins: the number that is looked at."""
    end: str
    """Where it ends: the number that is made of it."""
    weight: float
    """Its share of that number, -1 to 1: both in spreads, the shares' sizes together 1."""


@dataclass(frozen=True, kw_only=True)
class BodyNames:
    """What the numbers of a body are called."""

    body: str
    """The body."""
    state: tuple[str, ...]
    """Its state's numbers."""
    command: tuple[str, ...]
    """Its commands."""
    shown: int
    """How many of the state's first numbers are parts: velocities are told by positions."""


@dataclass(frozen=True, kw_only=True)
class Parts:
    """The arrows of a map."""

    states: tuple[Arrow, ...]
    """From numbers of the target's state to those of the source's."""
    commands: tuple[Arrow, ...]
    """From commands of the source to those of the target."""
    lost: tuple[str, ...]
    """Numbers of the target that no number of the source is made of."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spreads:
    """How far the numbers of a body usually are from rest."""

    state: Array
    """Of its state, shape (n,)."""
    command: Array
    """Of its commands, shape (nu,)."""


def names_of(body: Body) -> BodyNames:
    """Return what the numbers of a body's state about rest and of its commands are called."""
    robot = body.task.robot
    kinds = {
        "free": ("x", "y", "z", "roll", "pitch", "yaw"),
        "ball": ("roll", "pitch", "yaw"),
    }
    place = [
        f"{joint.link if joint.kind == 'free' else joint.name} {part}".rstrip()
        for joint in robot.joints
        for part in kinds.get(joint.kind, ("",) if joint.kind in {"hinge", "slide"} else ())
    ]
    half = body.size // 2
    # A body may be seen by what its task looks at alone, which is no joint of its own.
    if not _each(body.sight) or len(place) != half:
        place = list(READINGS.get(half, ())) or [f"reading {at + 1}" for at in range(half)]
    command = tuple(actuator.name for actuator in robot.actuators)
    if not _each(body.together):
        command = tuple(f"group {at + 1}" for at in range(len(body.bounds[0])))
    return BodyNames(
        body=robot.name,
        state=(*place, *(f"speed of {name}" for name in place)),
        command=command,
        shown=half,
    )


def _each(taken: Array | None) -> bool:
    """Return whether numbers are taken each by itself."""
    return taken is None or np.array_equal(taken, np.eye(len(taken)))


def parts(
    result: BodyMap, source: BodyNames, target: BodyNames, spread_s: Spreads, spread_t: Spreads
) -> Parts:
    """Return the arrows of a map near rest, the strongest of each number first.

    Args:
        result: The map.
        source: What its numbers are called.
        target: The same of the target.
        spread_s: How far the source's numbers usually are from rest.
        spread_t: The same of the target.
    """
    rest = np.zeros((1, len(target.state)))
    seen = _slope(result.state, spread_t.state) / _whole(spread_s.state)[:, None]
    command = (
        _slope(lambda u: result.action(np.repeat(rest, len(u), axis=0), u), spread_s.command)
        / (_whole(spread_t.command)[:, None])
    )
    states = _arrows(seen[: source.shown], target.state, source.state[: source.shown])
    commands = _arrows(command, source.command, target.command)
    used = {arrow.begin for arrow in states}
    return Parts(
        states=states,
        commands=commands,
        lost=tuple(name for name in target.state[: target.shown] if name not in used),
    )


def _whole(spread: Array) -> Array:
    return np.where(spread > 0.0, spread, 1.0)


def _slope(of: Callable[[Array], Array], spread: Array) -> Array:
    """Return how much each number given back grows by a spread of each number given."""
    move = STEP * np.diag(_whole(spread))
    return np.asarray((of(move) - of(-move)).T / (2.0 * STEP))


def _arrows(slope: Array, begins: Sequence[str], ends: Sequence[str]) -> tuple[Arrow, ...]:
    results: list[Arrow] = []
    for row, end in zip(slope, ends, strict=True):
        size = float(np.abs(row).sum())
        share = row / size if size > 1e-9 else np.zeros_like(row)
        results += [
            Arrow(begin=begins[at], end=end, weight=float(share[at]))
            for at in np.argsort(-np.abs(share), kind="stable")
            if abs(share[at]) >= LEAST
        ]
    return tuple(results)
