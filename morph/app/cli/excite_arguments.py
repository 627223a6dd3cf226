"""What `morph excite` takes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from morph.app.cli.options import Base, Folder, unset


@dataclass(frozen=True, kw_only=True)
class Excite:
    """Plan the cheapest experiment that tells two laws apart, or one for every law.

    Writes the commands to give the robot, within its limits, and how surely a diagnosis of what it
    then does will tell. Nothing need have been recorded.

    Example: morph excite so101 --separate coulomb_friction@Elbow torque_scale@Elbow
    --out plan
    """

    robot: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, xacro, MJCF, assembly.toml), a robot folder, or a name on the shelf."""
    out: Path
    """Folder for experiment.json and the commands of each run."""
    separate: Annotated[tuple[str, ...], unset("NAME@WHERE[:PARAM=VALUE,...] NAME@WHERE...")] = ()
    """Two laws, as `morph list effects` names them; without parameters at a usual size."""
    for_everything: bool = False
    """Plan up to four runs that show every law at every part, beside its twins there."""
    seconds: float = 20.0
    """The longest that a run may last, at least 5."""
    rate: float = 100.0
    """Readings a second."""
    noise: float = 5e-4
    """Standard deviation of a reading, rad or m."""
    vary: Annotated[tuple[str, ...], unset("NAME=FRACTION ...")] = ()
    """By how much parameters of the description may be wrong: as `morph diagnose --vary`."""
    seed: int = 0
    """Random seed of the motions."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing of the description is read; by default its own."""
    json: bool = False
    """Print experiment.json instead of words."""
    quiet: bool = False
    """Show no progress."""
