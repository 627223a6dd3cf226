"""What the viewer was asked to show, before anything is loaded."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from morph.body.robot import Robot


@dataclass(frozen=True, kw_only=True, eq=False)
class ViewRequest:
    """Bodies, and what is to be seen of them."""

    robots: tuple[Robot, ...]
    """Up to eight bodies; none if a transfer or a package names them."""
    asked: tuple[str, ...]
    """What each was asked for by: a name on the shelf or a path."""
    task: str | None = None
    """What all of them do."""
    policies: tuple[str, ...] = ()
    """Folders of policies, or `learned`."""
    recordings: tuple[Path, ...] = ()
    """Recordings of the first body."""
    root: Path | None = None
    """Folder that a recording.toml's files are relative to."""
    diagnosis: Path | None = None
    """Folder of a diagnosis of the first body."""
    transfer: Path | None = None
    """Folder of a transfer or an alignment."""
    package: Path | None = None
    """Folder of a package for the printer."""
    world: str | None = None
    """Where they move."""
    seconds: float | None = None
    """How long."""
    seed: int = 0
    """Random seed."""
    base: str | None = None
    """How bodies stand in the world, where a description does not say."""
    folder: Path | None = None
    """Folder outside which nothing of a description is read."""
