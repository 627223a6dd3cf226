"""What a slicer, or an estimate of one, says of a part as it lies on the bed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from morph.print.weight import Weight


@dataclass(frozen=True, kw_only=True, eq=False)
class Sliced:
    """How one copy of a part will come off the printer."""

    source: Literal["gcode", "estimate"]
    """Integrated from a slicer's G-code, or estimated layer by layer without one."""
    weight: Weight
    """What stays: mass, centre and inertia in the frame of the part, not of the bed."""
    support_kg: float
    """Plastic that is thrown away: support, skirt and brim, kg."""
    seconds: float
    """How long the printer takes."""
    by_feature: Mapping[str, float] = field(default_factory=dict)
    """Mass of each type of line, kg, by the slicer's name for it."""
    warnings: tuple[str, ...] = ()
    """What the slicer warned of, in its words."""
    gcode: bytes | None = None
    """The G-code that it was integrated from."""
    slicer: str = ""
    """Name and version of the slicer; empty for an estimate."""
