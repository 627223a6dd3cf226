"""A package: a print job, what it does to the robot, and the policy that goes with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from morph.arrays import JSON
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.packed import PackedPolicy
from morph.print.job import Job
from morph.print.part import Hinge
from morph.tabular import Tabular


@dataclass(frozen=True, kw_only=True, eq=False)
class Package(Tabular):
    """What `morph print` writes and `morph weigh` corrects."""

    name: str
    """The robot."""
    title: str
    """What to call it in a heading; from a file, so never to be trusted as HTML."""
    designed_sha256: str
    """Hash of the robot as designed."""
    made_sha256: str = ""
    """Hash of the robot as it comes off the printer; empty before it is written."""
    job: Job
    """What is printed, and how."""
    links: tuple[LinkMass, ...]
    """What each link weighs."""
    hinges: tuple[Hinge, ...] = ()
    """How the links move."""
    complete: frozenset[str] = frozenset()
    """Links of which everything that weighs is a part."""
    readings: Mapping[str, float] = field(default_factory=dict)
    """What a scale showed for one copy of a part, kg, by the part's name."""
    policy: PackedPolicy | None = None
    """What became of the policy; None if there is none."""
    notes: tuple[str, ...] = ()
    """What a reader should know."""
    command: str = ""
    """The command that made it."""
    folder: Path | None = None
    """Where it lies; None before it is written."""

    axes: ClassVar[tuple[str, ...]] = ("part", "grams")

    def __repr__(self) -> str:
        count = sum(part.count for part in self.job.parts if part.name in self.job.sliced)
        return f"Package({self.name}: {count} parts, {self.job.grams:.0f} g)"

    def rows(self) -> list[JSON]:
        """Return one row a printed part: copies, and mass and time of one copy."""
        return [
            {
                "part": part.name,
                "copies": part.count,
                "grams": 1e3 * self.job.sliced[part.name].weight.mass,
                "seconds": self.job.sliced[part.name].seconds,
            }
            for part in self.job.parts
            if part.name in self.job.sliced
        ]

    @property
    def designed_kg(self) -> float:
        """Mass by the description, kg."""
        return sum(each.designed.mass for each in self.links)

    @property
    def now_kg(self) -> float:
        """Mass that the robot is given, kg."""
        return sum(each.now.mass for each in self.links)
