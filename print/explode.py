"""Where the parts of a body go when it is drawn taken apart."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from morph.print.arrays import Array
from morph.print.part import Hinge, Part

APART = 0.05
"""Room between parts that were taken apart, by the diagonal of the body."""

DIRECT = 1.5
"""A part goes where it points unless another way is shorter by this factor."""

Copy = tuple[str, int]
"""A part's name and the number of its copy, from 0."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Explosion:
    """A body taken apart."""

    offsets: Mapping[Copy, Array]
    """How far each copy that has a shape is moved in the world, mm, shape (3,)."""
    parent: Mapping[str, str]
    """The link that carries each link; empty for the base, and what no joint holds."""
    links: tuple[str, ...]
    """Links that have parts, from the base outward."""

    def pose(self, part: Part, copy: int, factor: float = 1.0) -> Array:
        """Return where a copy is, from its frame into the world, shape (4, 4), mm.

        Args:
            part: A part of the body.
            copy: Which copy of it, from 0.
            factor: How far it is taken apart: 0 not at all, 1 wholly.
        """
        pose: Array = part.placements[copy].world.copy()
        pose[:3, 3] += factor * self.offsets.get((part.name, copy), np.zeros(3))
        return pose


@dataclass(frozen=True, kw_only=True, eq=False)
class _Piece:
    """One copy of a part that has a shape, as it sits in the body."""

    key: Copy
    part: Part
    link: str
    low: Array
    high: Array

    @property
    def middle(self) -> Array:
        return np.asarray(0.5 * (self.low + self.high))

    @property
    def size(self) -> float:
        return float(np.prod(self.high - self.low))


def exploded(parts: Sequence[Part], hinges: Sequence[Hinge]) -> Explosion:
    """Return how a body is taken apart so that each part is seen.

    Links go away from the link that carries them, along the line between their middles, and
    take with them all that they carry. Within a link what was bought leaves along the axis of
    its seat, and what was printed away from the largest part. Each goes as far as its box
    needs to be clear of every box that is there already.
    """
    pieces = [piece for part in parts for piece in _pieces(part)]
    by_link: dict[str, list[_Piece]] = {}
    for piece in pieces:
        by_link.setdefault(piece.link, []).append(piece)
    parent = carried(hinges)
    if not pieces:
        return Explosion(offsets={}, parent=parent, links=())
    low = np.min([piece.low for piece in pieces], axis=0)
    high = np.max([piece.high for piece in pieces], axis=0)
    gap = APART * float(np.linalg.norm(high - low))
    axes = {hinge.moving: hinge.axis for hinge in hinges}
    order = _outward(by_link, parent)
    base = max(order, key=lambda link: sum(piece.size for piece in by_link[link]))
    placed: list[tuple[Array, Array]] = []
    gone: dict[str, Array] = {}
    offsets: dict[Copy, Array] = {}
    for link in order:
        group = by_link[link]
        inner = _within(group, gap)
        holder = _holder(link, parent, by_link) or (base if link != base else "")
        start = gone.get(holder, np.zeros(3))
        away = _middle(group) - _middle(by_link[holder]) if holder else np.zeros(3)
        boxes = [
            (piece.low + inner[piece.key] + start, piece.high + inner[piece.key] + start)
            for piece in group
        ]
        step = _clear(boxes, placed, _ways(away, axes.get(link)), gap) if holder else np.zeros(3)
        gone[link] = start + step
        placed += [(a + step, b + step) for a, b in boxes]
        offsets |= {key: inner[key] + gone[link] for key in inner}
    return Explosion(offsets=offsets, parent=parent, links=tuple(order))


def carried(hinges: Sequence[Hinge]) -> dict[str, str]:
    """Return the link that carries each link: where a chain closes, the first that is named."""
    parent: dict[str, str] = {}
    for hinge in hinges:
        if hinge.moving not in parent and not _hangs(hinge.still, hinge.moving, parent):
            parent[hinge.moving] = hinge.still
    return parent


def _hangs(link: str, on: str, parent: Mapping[str, str]) -> bool:
    """Return whether a link is, or hangs from, another."""
    while link and link != on:
        link = parent.get(link, "")
    return link == on


def _pieces(part: Part) -> list[_Piece]:
    if part.mesh is None:
        return []
    results = []
    for copy, placement in enumerate(part.placements):
        corners = part.mesh.vertices @ placement.world[:3, :3].T + placement.world[:3, 3]
        results.append(
            _Piece(
                key=(part.name, copy),
                part=part,
                link=placement.link,
                low=corners.min(axis=0),
                high=corners.max(axis=0),
            )
        )
    return results


def _outward(by_link: Mapping[str, Sequence[_Piece]], parent: Mapping[str, str]) -> list[str]:
    """Return links that have parts, each after those that it hangs from."""
    below: dict[str, list[str]] = {}
    for link, holder in parent.items():
        below.setdefault(holder, []).append(link)
    every = dict.fromkeys((*by_link, *parent.values()))
    results: list[str] = []
    waiting = deque(link for link in every if link not in parent)
    while waiting:
        link = waiting.popleft()
        results.append(link)
        waiting.extend(below.get(link, ()))
    return [link for link in results if link in by_link]


def _holder(link: str, parent: Mapping[str, str], by_link: Mapping[str, object]) -> str:
    """Return the nearest link towards the base that has parts."""
    link = parent.get(link, "")
    while link and link not in by_link:
        link = parent.get(link, "")
    return link


def _within(group: Sequence[_Piece], gap: float) -> dict[Copy, Array]:
    """Return how the parts of one link leave its largest printed part."""
    ours = [piece for piece in group if piece.part.kind == "printed"] or list(group)
    main = max(ours, key=lambda piece: piece.size)
    results = {main.key: np.zeros(3)}
    placed = [(main.low, main.high)]
    others = [piece for piece in group if piece.key != main.key]
    # Pieces of one part first: what was bought goes around all of them.
    for piece in sorted(others, key=lambda each: each.part.kind == "bought"):
        if piece.part.kind == "fused":
            results[piece.key] = np.zeros(3)
            continue
        seat = _seat_axis(piece, ours) if piece.part.kind == "bought" else None
        away = piece.middle - main.middle if seat is None else seat
        ways = _ways(away, None) if seat is None else [seat]
        results[piece.key] = _clear([(piece.low, piece.high)], placed, ways, 0.5 * gap)
        step = results[piece.key]
        placed.append((piece.low + step, piece.high + step))
    return results


def _seat_axis(piece: _Piece, ours: Sequence[_Piece]) -> Array | None:
    """Return the axis in the world of the seat that a bought part sits in; None: in none."""
    best, nearest = None, np.inf
    reach = float(np.linalg.norm(piece.high - piece.low))
    for holder in ours:
        world = holder.part.placements[holder.key[1]].world
        for seat in holder.part.seats:
            where = world[:3, :3] @ seat.position + world[:3, 3]
            far = float(np.linalg.norm(where - piece.middle))
            if far < min(nearest, reach):
                best, nearest = world[:3, :3] @ seat.axis, far
    return best


def _middle(group: Sequence[_Piece]) -> Array:
    low = np.min([piece.low for piece in group], axis=0)
    high = np.max([piece.high for piece in group], axis=0)
    return np.asarray(0.5 * (low + high))


def _ways(away: Array, axis: Array | None) -> list[Array]:
    """Return unit vectors to go along: the first is the natural one."""
    length = float(np.linalg.norm(away))
    first = away / length if length > 1e-6 else axis
    if first is None:
        first = np.array([0.0, 0.0, 1.0])
    nearest = np.zeros(3)
    at = int(np.abs(first).argmax())
    nearest[at] = np.sign(first[at])
    others = [] if axis is None else [axis * (np.sign(axis @ first) or 1.0)]
    return [np.asarray(first), nearest, *others]


def _clear(
    boxes: Sequence[tuple[Array, Array]],
    placed: Sequence[tuple[Array, Array]],
    ways: Sequence[Array],
    gap: float,
) -> Array:
    """Return the shift along one of the ways after which no box is nearer than a gap.

    A box overlaps another while its shift is, for each axis, between two bounds; the least
    shift that is within none of these intervals is the nearest one that is clear.
    """
    if not placed or not boxes:
        return np.zeros(3)
    best, least = np.zeros(3), np.inf
    for number, way in enumerate(ways):
        far = _least(boxes, placed, way, gap) * (DIRECT if number else 1.0)
        if far < least:
            best, least = way * far / (DIRECT if number else 1.0), far
    return best


def _least(
    boxes: Sequence[tuple[Array, Array]],
    placed: Sequence[tuple[Array, Array]],
    way: Array,
    gap: float,
) -> float:
    low, high = (np.array(each)[:, None] for each in zip(*boxes, strict=True))
    other_low, other_high = (np.array(each)[None] for each in zip(*placed, strict=True))
    first, last = other_low - gap - high, other_high + gap - low
    with np.errstate(divide="ignore", invalid="ignore"):
        bounds = np.sort(np.stack((first / way, last / way)), axis=0)
    # Along an axis in which it does not move it overlaps always or never.
    rests = np.abs(way) < 1e-9
    meets = (first < 0.0) & (last > 0.0)
    begin = np.where(rests, np.where(meets, -np.inf, np.inf), bounds[0]).max(axis=-1)
    end = np.where(rests, np.where(meets, np.inf, -np.inf), bounds[1]).min(axis=-1)
    touched = end > begin
    shift = 0.0
    for start, stop in sorted(zip(begin[touched].tolist(), end[touched].tolist(), strict=True)):
        if start > shift:
            break
        shift = max(shift, stop)
    return shift
