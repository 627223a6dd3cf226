"""What a body is made of: parts that are printed, bought, or fused into another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from morph.print.arrays import Array
from morph.print.mesh import Mesh
from morph.print.weight import Weight


@dataclass(frozen=True, kw_only=True, eq=False)
class Seat:
    """Where something is held in a part: what, at which place, along which axis."""

    holds: str
    """A servo, a horn, a bearing or a screw, by its name in the catalogue."""
    position: Array
    """Its origin in the part's frame, mm, shape (3,)."""
    axis: Array
    """Its axis, a unit vector out of the part, shape (3,)."""
    bore_mm: float
    """Diameter of the hole about the axis; 0 where there is none."""
    pocket: Mesh | None = None
    """What must be empty for it to go in, in the part's frame; None: the bore is all."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Placement:
    """Where one copy of a part sits in the body."""

    link: str
    """The link that carries it."""
    pose: Array
    """From the part's frame into the link's, shape (4, 4), mm."""
    world: Array
    """From the part's frame into the world's with all joints at zero, shape (4, 4), mm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Part:
    """Something that a body has one or more of."""

    name: str
    """Unique in its list; lower case, digits and underscores, so that it names files."""
    kind: Literal["printed", "bought", "fused"]
    """How it comes to be; what is fused is printed in one piece with `into`."""
    mesh: Mesh | None
    """Its solid in its own frame; None of something bought whose shape is not known."""
    placements: tuple[Placement, ...]
    """Where each copy sits; as many as there are copies."""
    hand: Literal["", "left", "right"] = ""
    """Set if a mirrored twin is in the list: the two must not be mistaken."""
    seats: tuple[Seat, ...] = ()
    """What is held in it."""
    weight: Weight | None = None
    """Of one copy in its own frame: known of what is bought, predicted of what is printed."""
    into: str = ""
    """The part into which it is fused."""
    number: str = ""
    """Part number, such as `P-03`, as it stands in the bill of materials and the 3MF."""
    piece_of: str = ""
    """The part that was too large for the bed, of which this is a piece."""

    @property
    def count(self) -> int:
        """How many copies there are."""
        return len(self.placements)


@dataclass(frozen=True, kw_only=True, eq=False)
class Hinge:
    """A joint as print sees it: an axis between two groups of solids in the world at zero."""

    name: str
    """What to call it."""
    kind: Literal["hinge", "slide"]
    """Whether it turns or slides."""
    position: Array
    """A point on its axis in the world, mm, shape (3,)."""
    axis: Array
    """Unit vector in the world, shape (3,)."""
    low: float
    """Least position, rad or mm."""
    high: float
    """Greatest position, rad or mm."""
    still: str
    """The link that stays."""
    moving: str
    """The link that moves."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """One thing that was looked at before a slicer is asked, and what was found."""

    part: str
    """The part, or the joint, looked at."""
    name: str
    """What was checked, such as `wall` or `bed fit`."""
    verdict: Literal["passed", "noted", "refused"]
    """`noted`: it can be printed, and somebody should look."""
    what: str
    """What was found, with the value and the values allowed."""
    fix: str = ""
    """How to put it right; empty if nothing is to be done."""
    value: float | None = None
    """The number found, in the unit that `what` names."""
    limit: float | None = None
    """The number allowed."""
