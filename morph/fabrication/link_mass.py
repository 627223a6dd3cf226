"""What a link weighs: as designed, as predicted from its parts, and as a scale showed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from morph.print.weight import Weight

Source = Literal["description", "estimate", "gcode", "scale"]
"""Where a mass comes from, the least to be trusted first."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinkMass:
    """One link's mass, each in the link's frame."""

    link: str
    """The link."""
    designed: Weight
    """What the description says."""
    predicted: Weight | None
    """Printed and bought parts together; None where not all of them are known."""
    measured: Weight | None
    """The same with what the scale showed; None before anything was weighed."""
    source: Source
    """Where the mass that the robot now has comes from."""

    @property
    def now(self) -> Weight:
        """What the robot is given."""
        return self.measured or self.predicted or self.designed
