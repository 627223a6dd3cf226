"""Contents of a folder of an alignment or transfer, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from morph.policy_transfer.hop_result import Crossing
from morph.policy_transfer.parts import Parts
from morph.policy_transfer.transfer_record import GuardRecord


@dataclass(frozen=True, kw_only=True, eq=False)
class Told:
    """What is told of one hop."""

    source: str
    """What the source is called."""
    target: str
    """What the target is called."""
    map: Path | None
    """The file of its map; None where both bodies have the same joints, or the file is gone."""
    mapper: str
    """How the map was learned, or what sort of map it is."""
    parts: Parts
    """Which part is which."""
    quality: Mapping[str, float]
    """How good the map is; NaN for what is not a number."""
    guard: GuardRecord
    """What is thought of the policy before it is tried."""
    why: str = ""
    """Why the guard says so; empty if nothing is told."""
    samples: int = 0
    """Transitions of the target."""
    scores: Mapping[str, float | None] = field(default_factory=dict)
    """As shares of what the oracle gains over holding still; empty if none were measured."""
    crossing: Crossing | None = None
    """The hop as the reports know it; None for what is no hop of a relay."""
    notes: tuple[str, ...] = ()
    """What else is to be known of it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Story:
    """All that a folder tells."""

    folder: Path
    """The folder."""
    command: str
    """What wrote it: `align`, `transfer` or `loop`."""
    hops: tuple[Told, ...]
    """In order; the target of one is the source of the next."""
    asked: tuple[str | None, ...]
    """What the bodies were asked for by, in the order of the chain, None for a recording; empty
    if it is not told. It was written by whoever wrote the folder."""
    hashes: Mapping[str, str]
    """Hashes of what was given, by what it is."""
    policy: Path | None = None
    """Folder of the last body's policy."""
    notes: tuple[str, ...] = ()
    """What else is to be known."""

    @property
    def chain(self) -> tuple[str, ...]:
        """Names of the bodies in order."""
        return (self.hops[0].source, *(hop.target for hop in self.hops))

    def law(self, body: int) -> Path | None:
        """Return the file of the law that a hop made for a body of the chain, if there is one."""
        path = self.folder / "hops" / f"{body:02d}" / "law.npz"
        return path if body and path.is_file() else None
