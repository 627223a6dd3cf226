"""What each command takes; light, so that `morph --help` answers at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro


@dataclass(frozen=True, kw_only=True)
class Diagnose:
    """Say where a robot's description and its recordings part, and what physics was left out.

    Example: morph diagnose double_pendulum rig.toml --held-out run_03 run_05 --out report
    """

    robot: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, MJCF), a robot folder, or a name on the shelf."""
    recordings: Annotated[
        tyro.conf.Positional[tuple[Path, ...]], tyro.conf.arg(metavar="RECORDING ...")
    ]
    """Files or folders: CSV, NPZ, Parquet with canonical columns, or a recording.toml."""
    out: Path
    """Folder for diagnosis.json, report.html and the corrected model."""
    held_out: tuple[str, ...] = ()
    """Recordings, or names of episodes, to open only after the choice; none: a quarter."""
    only: tuple[str, ...] = ()
    """Names of the episodes to fit; none: all that are not held out."""
    horizon: str = "1.0"
    """Seconds of the rollouts on which errors are reported, or `full` for whole episodes."""
    vary: Annotated[tuple[str, ...], tyro.conf.arg(metavar="NAME=FRACTION ...")] = ()
    """By how much figures may be wrong: mass=0.3, mass:pole=0, com, inertia, gain, joint."""
    root: Path | None = None
    """Folder that a recording.toml's files are relative to, instead of its own `root`."""
    budget: float | None = None
    """Seconds after which the best answer so far is written (exit status 3)."""
    seed: int = 0
    """Of every draw."""
    json: bool = False
    """Print diagnosis.json instead of words."""
    quiet: bool = False
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class List:
    """List what morph knows.

    Example: morph list effects
    """

    what: tyro.conf.Positional[Literal["robots", "effects"]]
    """robots: the shelf. effects: the physics that can be simulated and found."""
    json: bool = False
    """Print JSON."""
