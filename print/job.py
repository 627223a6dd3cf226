"""A print job as data: what is printed, how it lies, and what will come off the printer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from morph.print.arrays import Array
from morph.print.part import Check, Part
from morph.print.printer import Profile
from morph.print.sliced import Sliced


@dataclass(frozen=True, kw_only=True, eq=False)
class Orientation:
    """How a part lies on the bed."""

    turn: Array
    """Rotation from the part's frame to the bed's, z up, shape (3, 3)."""
    support_mm3: float
    """Volume under faces that need support."""
    first_support_mm3: float
    """The same as the part was given, without turning it."""
    height_mm: float
    """How high it stands."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Laid:
    """One copy of a part on a plate."""

    part: str
    """The part's name."""
    copy: int
    """Which of its copies, from 0."""
    pose: Array
    """From the part's frame to the plate's, whose corner is the origin, shape (4, 4), mm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Plate:
    """What is printed at once."""

    name: str
    """Such as `plate_1`."""
    laid: tuple[Laid, ...]
    """Everything on it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Job:
    """Everything about a print."""

    profile: Profile
    """Printer, material and settings."""
    parts: tuple[Part, ...]
    """Printed, bought and fused; what was too large is there as its pieces."""
    refused: tuple[Part, ...]
    """Parts that no slicer was asked about; their checks say why."""
    checks: tuple[Check, ...]
    """Everything that was looked at."""
    orientations: Mapping[str, Orientation]
    """How each printed part lies, by its name."""
    sliced: Mapping[str, Sliced]
    """What one copy of each printed part will be, by its name."""
    plates: tuple[Plate, ...]
    """What is printed together."""
    gauges: tuple[Part, ...] = ()
    """What to print first, to see whether the play fits."""
    notes: tuple[str, ...] = ()
    """What a reader should know, such as that no slicer was found."""

    @property
    def grams(self) -> float:
        """Mass of all that is printed and stays, g."""
        return 1e3 * sum(
            self.sliced[part.name].weight.mass * part.count
            for part in self.parts
            if part.name in self.sliced
        )

    @property
    def seconds(self) -> float:
        """How long all of it takes, one part at a time."""
        return sum(
            self.sliced[part.name].seconds * part.count
            for part in self.parts
            if part.name in self.sliced
        )
