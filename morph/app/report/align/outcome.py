"""All that `morph align` found out, and how `align.json` tells it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import ClassVar

import morph
from morph.alignment.maps.body_map import BodyMap
from morph.arrays import JSON
from morph.policy_transfer.hop_result import parts_said
from morph.policy_transfer.parts import BodyNames, Parts
from morph.policy_transfer.transfer_record import GuardRecord
from morph.tabular import Tabular

SCHEMA = "morph.align/1"
"""Name and version of `align.json` and of what `--json` prints."""

MAP = "maps/01_body_map.npz"
"""Where the map stands beside `align.json`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Aligned(Tabular):
    """A map between two bodies, and what is thought of it."""

    source: BodyNames
    """What the source's numbers are called."""
    target: BodyNames
    """The same of the target."""
    mapper: str
    """How the map was learned."""
    map: BodyMap
    """The map."""
    parts: Parts
    """Which part is which, by it."""
    quality: Mapping[str, float]
    """How good it is on transitions that it was not learned from."""
    guard: GuardRecord
    """Whether the source's policy may be tried through it."""
    why: str
    """Why the guard says so, in a sentence; empty if there is nothing to say."""
    samples: tuple[int, int]
    """Transitions of the source and of the target that it was learned from."""
    held_out: int
    """Transitions of the target on which it was judged."""
    seed: int
    """Random seed."""
    seconds: float
    """Time that was spent, s."""
    command: str
    """The command that led to it."""
    inputs: Mapping[str, str]
    """Hashes of what was given, by what it is."""
    notes: tuple[str, ...] = ()
    """What else is to be known."""

    axes: ClassVar[tuple[str, ...]] = ("measure", "value")

    def __repr__(self) -> str:
        return f"Aligned({self.target.body} as {self.source.body}: {self.guard.verdict})"

    def rows(self) -> list[JSON]:
        """Return one row for each measure of the map's quality on held-out transitions."""
        return [{"measure": name, "value": float(each)} for name, each in self.quality.items()]

    def save(self, folder: str | Path) -> None:
        """Write the map, report.html and align.json, as `morph align` does.

        Raises:
            OutputError: The folder cannot be written.
        """
        from morph.app.report.align.files import write_align

        write_align(self, Path(folder))

    def said(self) -> JSON:
        """Return all of it by the schema morph.align/1; a number that is not finite is null."""
        return {
            "schema": SCHEMA,
            "source": names_said(self.source),
            "target": names_said(self.target),
            "map": MAP,
            "mapper": self.mapper,
            "kind": self.map.kind,
            "parts": parts_said(self.parts),
            "quality": {name: finite(value) for name, value in self.quality.items()},
            "guard": {**vars(self.guard), "why": self.why},
            "samples": {
                "source": self.samples[0], "target": self.samples[1], "held_out": self.held_out,
            },
            "seed": self.seed,
            "seconds": self.seconds,
            "notes": list(self.notes),
            "provenance": {
                "morph": morph.__version__,
                "mujoco": version("mujoco"),
                "inputs": dict(self.inputs),
                "command": self.command,
            },
        }  # fmt: skip

    def text(self) -> str:
        """Return the text of `align.json`."""
        return json.dumps(self.said(), allow_nan=False, indent=1) + "\n"


def names_said(names: BodyNames) -> JSON:
    """Return what the numbers of a body are called as plain data."""
    return {"name": names.body, "state": list(names.state), "command": list(names.command)}


def finite(value: float) -> float | None:
    """Return a number, or None if it is none."""
    return float(value) if math.isfinite(value) else None
