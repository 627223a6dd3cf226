"""Everything that is printed, laid on as few plates as it fits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from morph.print.arrays import Array
from morph.print.bed import MARGIN_MM, hull, room
from morph.print.errors import PlateError
from morph.print.job import Laid, Orientation, Plate
from morph.print.part import Part
from morph.print.printer import Profile

SPACING_MM = 6.0
"""Between the boxes around two parts: room for both their brims, and for a knife."""

QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""A quarter turn about upright."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Box:
    """One copy of a part, as a rectangle that is to be laid."""

    part: str
    copy: int
    turn: Array
    low: Array
    size: Array


@dataclass(kw_only=True)
class _Sheet:
    """A plate that is being filled, by the rectangles that are still free on it.

    Source: Jylänki 2010, A Thousand Ways to Pack the Bin, section 2.3 (maximal rectangles).
    """

    free: list[tuple[float, float, float, float]]
    laid: list[tuple[_Box, float, float, bool]] = field(default_factory=list)

    def lay(self, box: _Box) -> bool:
        """Lay a box where it leaves the shortest side over; return whether it fitted."""
        best: tuple[float, float, int, bool] | None = None
        sizes = ((False, box.size[0], box.size[1]), (True, box.size[1], box.size[0]))
        for at, (_, _, width, depth) in enumerate(self.free):
            for turned, wide, deep in sizes:
                if wide <= width + 1e-9 and deep <= depth + 1e-9:
                    left = sorted((width - wide, depth - deep))
                    score = (left[0], left[1], at, turned)
                    best = score if best is None or score < best else best
        if best is None:
            return False
        _, _, at, turned = best
        x, y = self.free[at][:2]
        wide, deep = (box.size[1], box.size[0]) if turned else (box.size[0], box.size[1])
        self.laid.append((box, x, y, turned))
        self._take(x, y, wide, deep)
        return True

    def _take(self, x: float, y: float, wide: float, deep: float) -> None:
        """Cut a rectangle out of all that is free."""
        rest = []
        for fx, fy, fw, fd in self.free:
            if x >= fx + fw or fx >= x + wide or y >= fy + fd or fy >= y + deep:
                rest.append((fx, fy, fw, fd))
                continue
            rest += [
                (fx, fy, x - fx, fd),
                (x + wide, fy, fx + fw - x - wide, fd),
                (fx, fy, fw, y - fy),
                (fx, y + deep, fw, fy + fd - y - deep),
            ]
        rest = [each for each in dict.fromkeys(rest) if each[2] > 1e-9 and each[3] > 1e-9]
        self.free = [
            each for each in rest if not any(_within(each, of) for of in rest if of != each)
        ]


def _within(
    one: tuple[float, float, float, float], other: tuple[float, float, float, float]
) -> bool:
    return (
        one[0] >= other[0]
        and one[1] >= other[1]
        and one[0] + one[2] <= other[0] + other[2]
        and one[1] + one[3] <= other[1] + other[3]
    )


def plates(
    parts: Sequence[Part], orientations: Mapping[str, Orientation], profile: Profile
) -> tuple[Plate, ...]:
    """Return every copy of every part on as few plates as were found to do.

    Boxes around the parts are laid largest first, in three meanings of large, and the fewest
    plates win.

    Args:
        parts: What is printed; a part is laid as often as it has placements.
        orientations: How each lies, by its name.
        profile: Names the printer.

    Raises:
        PlateError: A part has no mesh or orientation, or is larger than the bed.
    """
    boxes = [box for part in parts for box in _boxes(part, orientations, profile)]
    orders = (
        lambda box: (-box.size.prod(), box.part, box.copy),
        lambda box: (-box.size.max(), -box.size.min(), box.part, box.copy),
        lambda box: (-box.size.sum(), box.part, box.copy),
    )
    filled = min((_filled(sorted(boxes, key=order), profile) for order in orders), key=len)
    return tuple(
        Plate(name=f"plate_{at}", laid=tuple(_laid(*each) for each in sheet.laid))
        for at, sheet in enumerate(filled, start=1)
    )


def _boxes(
    part: Part, orientations: Mapping[str, Orientation], profile: Profile
) -> tuple[_Box, ...]:
    """Return a part's copies as boxes, or refuse it."""
    if part.mesh is None or part.name not in orientations:
        raise PlateError(
            "the part has no mesh" if part.mesh is None else "nobody said how the part lies",
            where=f"part {part.name}",
            fix="hand over printed parts only, each with its orientation",
        )
    turn = orientations[part.name].turn
    lying = hull(part.mesh) @ turn.T
    low = lying.min(axis=0)
    size = lying.max(axis=0) - low
    allowed = room(profile)
    flat, bed = np.sort(size[:2]), np.sort(allowed[:2])
    if (flat > bed + 1e-6).any() or size[2] > allowed[2] + 1e-6:
        raise PlateError(
            f"the part is {' x '.join(f'{length:.1f}' for length in size)} mm as it lies, and "
            f"the {profile.printer.title} has room for "
            f"{' x '.join(f'{length:.0f}' for length in allowed)}",
            where=f"part {part.name}",
            fix="turn it (print.orient), split it (print.split), or name a larger printer",
        )
    return tuple(
        _Box(part=part.name, copy=copy, turn=turn, low=low, size=size[:2] + SPACING_MM)
        for copy in range(part.count)
    )


def _filled(boxes: Sequence[_Box], profile: Profile) -> list[_Sheet]:
    """Return plates filled one box after the other, each on the first plate that has room."""
    # Each box carries its spacing on two sides; the bed carries it once more, beyond its edge.
    width, depth = (float(length) for length in room(profile)[:2] + SPACING_MM + 1e-6)
    sheets: list[_Sheet] = []
    for box in boxes:
        if not any(sheet.lay(box) for sheet in sheets):
            sheets.append(_Sheet(free=[(0.0, 0.0, width, depth)]))
            sheets[-1].lay(box)
    return sheets


def _laid(box: _Box, x: float, y: float, turned: bool) -> Laid:
    """Return where a copy lies: its lowest point on the bed, its box from the corner on."""
    pose = np.eye(4)
    pose[:3, :3] = QUARTER @ box.turn if turned else box.turn
    low = box.low
    if turned:
        # A quarter turn takes (x, y) to (-y, x); the size holds the spacing, which is none of it.
        low = np.array([-(box.low[1] + box.size[1] - SPACING_MM), box.low[0], box.low[2]])
    pose[:3, 3] = np.array([x + MARGIN_MM, y + MARGIN_MM, 0.0]) - low
    return Laid(part=box.part, copy=box.copy, pose=pose)
