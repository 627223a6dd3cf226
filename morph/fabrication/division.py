"""How a body divides into parts: the answer of `divide`, as data."""

from __future__ import annotations

from dataclasses import dataclass

from morph.body.robot import Robot
from morph.print.part import Check, Hinge, Part


@dataclass(frozen=True, kw_only=True, eq=False)
class Division:
    """What of a body is printed, bought or fused, and how its parts move."""

    robot: Robot
    """The body as it was designed."""
    parts: tuple[Part, ...]
    """Every part; those that are alike are one part with several placements."""
    hinges: tuple[Hinge, ...]
    """Every hinge and slide between two links."""
    checks: tuple[Check, ...] = ()
    """Links of which no part can be made, and what was found while parts were made."""
    notes: tuple[str, ...] = ()
    """What a reader should know, such as what was assumed."""
    complete: frozenset[str] = frozenset()
    """Links of which all is known that weighs: what is printed and what is bought."""
