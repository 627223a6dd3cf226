"""A part that is larger than the bed, cut into pieces that go together one way only."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from morph.print.arrays import Array
from morph.print.bed import room
from morph.print.cut import Plane, chosen, cut, even, plans, rotated
from morph.print.errors import SolidError, SplitError
from morph.print.key import keyed
from morph.print.mesh import Mesh, from_manifold
from morph.print.orient import fits
from morph.print.part import Part, Seat
from morph.print.printer import Profile

FREEDOM = (0.3, 0.12, 0.0)
"""How far planes may move to a better place, in slices; less where slices become too long."""

PATIENCE = 8
"""Ways of cutting into pieces that fit, none of which has room for pins, before giving up."""

ASIDE_MM = 3.0
"""How far from a seat nothing is cut."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Whole:
    """A part turned so that its cuts lie along the axes."""

    part: Part
    solid: Any
    turn: Array
    low: Array
    size: Array


def split(part: Part, profile: Profile) -> tuple[Part, ...]:
    """Return the pieces of a part; the part itself where it fits the bed.

    The fewest slices along the axes of its least box are tried first. Between two pieces stand a
    thicker and a thinner pin, or one D, each in one piece and with play in the other. A piece
    carries the seats that lie in it and is placed as the part was.

    Raises:
        SplitError: It cannot be cut so that its pieces fit the bed and go together.
    """
    if part.mesh is None or fits(part.mesh, profile):
        return (part,)
    whole = _whole(part)
    loose = []
    for planes in _ways(whole, profile):
        pieces = cut(whole.solid, planes)
        if not _all_fit(pieces, profile):
            continue
        result = keyed(pieces, planes, profile)
        if not result.loose and _all_fit(result.solids, profile):
            return _named(whole, result.solids)
        loose.append(result.loose)
        if len(loose) == PATIENCE:
            break
    raise _refused(whole, next(filter(None, loose), ""), profile)


def _whole(part: Part) -> _Whole:
    """Return a part as a solid along the axes of its least box."""
    import trimesh

    mesh = part.mesh
    try:
        if mesh is None:
            raise SolidError("it has no mesh", where=f"part {part.name}", fix="give it one")
        solid = mesh.manifold
    except SolidError as error:
        raise SplitError(
            f"what is no solid cannot be cut: {error.what}",
            where=f"part {part.name}",
            fix=error.fix,
        ) from error
    least = np.array(trimesh.bounds.oriented_bounds(mesh.trimesh)[0])[:3, :3]  # type: ignore[no-untyped-call]
    inside = np.ptp(mesh.vertices @ least.T, axis=0)
    # Where its own axes do as well, it is cut along them, as whoever drew it would.
    turn = np.eye(3) if mesh.extent.prod() < 1.02 * inside.prod() else least
    turned = rotated(solid, turn)
    bounds = np.array(turned.bounding_box()).reshape(2, 3)
    return _Whole(part=part, solid=turned, turn=turn, low=bounds[0], size=bounds[1] - bounds[0])


def _ways(whole: _Whole, profile: Profile) -> Iterator[tuple[Plane, ...]]:
    """Yield planes to cut by, those that leave the fewest pieces first."""
    taken = [_taken(whole, axis) for axis in range(3)]
    for counts in plans(whole.size, room(profile)):
        if not _all_fit(cut(whole.solid, even(whole.size, whole.low, counts)), profile):
            continue
        for freedom in FREEDOM:
            along = [
                chosen(whole.solid, axis, count, freedom, taken[axis])
                for axis, count in enumerate(counts)
            ]
            if all(planes is not None for planes in along):
                yield tuple(plane for planes in along for plane in planes or ())


def _taken(whole: _Whole, axis: int) -> list[tuple[float, float]]:
    """Return the spans of an axis where seats are, mm."""
    spans = []
    for seat in whole.part.seats:
        if seat.pocket is None:
            at = float(whole.turn[axis] @ seat.position)
            begin, end = at - 0.5 * seat.bore_mm, at + 0.5 * seat.bore_mm
        else:
            along = seat.pocket.vertices @ whole.turn[axis]
            begin, end = float(along.min()), float(along.max())
        spans.append((begin - ASIDE_MM, end + ASIDE_MM))
    return spans


def _all_fit(solids: Sequence[Any], profile: Profile) -> bool:
    return all(fits(from_manifold(solid), profile) for solid in solids)


def _named(whole: _Whole, solids: Sequence[Any]) -> tuple[Part, ...]:
    """Return the pieces as parts in the frame of the whole, in the order of their middles."""
    boxes = [np.array(solid.bounding_box()).reshape(2, 3).mean(axis=0).round(3) for solid in solids]
    order = sorted(range(len(solids)), key=lambda at: tuple(boxes[at]))
    meshes = [from_manifold(rotated(solids[at], whole.turn.T)) for at in order]
    owner = [_owner(seat, meshes) for seat in whole.part.seats]
    number = whole.part.number
    return tuple(
        replace(
            whole.part,
            name=f"{whole.part.name}_{at}",
            mesh=mesh,
            seats=tuple(
                seat for seat, of in zip(whole.part.seats, owner, strict=True) if of == at - 1
            ),
            weight=None,
            number=f"{number}-{at}" if number else "",
            piece_of=whole.part.name,
        )
        for at, mesh in enumerate(meshes, start=1)
    )


def _owner(seat: Seat, meshes: Sequence[Mesh]) -> int:
    """Return which piece a seat is in: the one that is nearest to it."""
    import manifold3d

    probe = manifold3d.Manifold.sphere(0.1, 8).translate(tuple(seat.position))
    gaps = [mesh.manifold.min_gap(probe, 1e4) for mesh in meshes]
    return int(np.argmin(gaps))


def _refused(whole: _Whole, loose: str, profile: Profile) -> SplitError:
    size = " x ".join(f"{length:.0f}" for length in whole.size)
    bed = " x ".join(f"{length:.0f}" for length in room(profile))
    why = loose or "no cut that spares its seats leaves pieces that fit"
    return SplitError(
        f"a part of {size} mm is too large for the {bed} mm of the "
        f"{profile.printer.title}, and cannot be cut: {why}",
        where=f"part {whole.part.name}",
        fix="name a larger printer, make it stouter where it may be cut, or draw it in pieces",
    )
