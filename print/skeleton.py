"""What a part without a mesh is grown from: simple solids, and what it must hold and spare."""

from __future__ import annotations

from dataclasses import dataclass

from morph.print.arrays import Array
from morph.print.mesh import Mesh


@dataclass(frozen=True, kw_only=True, eq=False)
class Mount:
    """A servo in a part, or a servo's horn on the part that it turns."""

    servo: str
    """The servo's name in the catalogue."""
    pose: Array
    """From the servo's frame (origin where its axis leaves the case, z along the axis out of
    the case, x along its length towards its far end) to the part's, shape (4, 4), mm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Pivot:
    """A joint without a servo: an axle through two parts that lie side by side."""

    position: Array
    """Its middle in the part's frame, mm, shape (3,)."""
    axis: Array
    """Unit vector in the part's frame, shape (3,)."""
    side: int
    """1: this part lies on the side to which the axis points; -1: on the other."""
    bearing: str
    """A bearing or a screw of the catalogue."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Skeleton:
    """One part before it has a shape, in its own frame."""

    name: str
    """The part's name."""
    solids: tuple[Mesh, ...]
    """Simple solids that are its body; they may overlap or be apart."""
    servos: tuple[Mount, ...] = ()
    """Servos that sit in it."""
    horns: tuple[Mount, ...] = ()
    """Servos elsewhere whose horns turn it."""
    pivots: tuple[Pivot, ...] = ()
    """Joints without a servo."""
    boxes: tuple[Mesh, ...] = ()
    """Other bought things that sit in it, such as cells: each needs its room."""
    spared: tuple[Mesh, ...] = ()
    """Room that others sweep: nothing of the part may be there."""
