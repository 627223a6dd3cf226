"""What `morph print` takes; light, so that `morph --help` answers at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

import tyro

from morph.app.cli.options import Base, Folder, unset


@dataclass(frozen=True, kw_only=True)
class Print:
    """Make parts of a body for a printer, and the robot and the policy that fit what comes off it.

    Every part is looked at before a slicer is asked; PrusaSlicer is asked where there is one.
    Exit status 3: some parts cannot be printed; the package holds the others, and says why.

    Example: morph print so101 --printer mk4 --material pla --out package
    """

    robot: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, xacro, MJCF, assembly.toml), a robot folder, or a name on the shelf."""
    printer: Annotated[str, tyro.conf.arg(metavar="NAME")]
    """The printer: a name from `morph list printers`."""
    material: Annotated[str, tyro.conf.arg(metavar="NAME")]
    """The plastic: a name from `morph list materials`."""
    out: Annotated[str, tyro.conf.arg(metavar="DIR")]
    """Folder for the package; an earlier package in it is replaced when the new one is whole."""
    policy: Annotated[str | None, unset("DIR")] = None
    """Folder of the body's policy: it is matched to the printed robot."""
    seconds: float = 60.0
    """Longest that matching the policy may take."""
    slicer: Literal["auto", "needed", "none"] = "auto"
    """Ask PrusaSlicer if it is there; refuse to go on without it; or estimate."""
    gcode: bool = True
    """Slice whole plates too, if a slicer is asked; --no-gcode leaves that to you."""
    timeout: Annotated[float, tyro.conf.arg(metavar="SECONDS")] = 300.0
    """Longest that the slicer may take for one part."""
    layer: Annotated[float, tyro.conf.arg(metavar="MM")] = 0.2
    """Height of a layer, mm."""
    walls: Annotated[int, tyro.conf.arg(metavar="N")] = 2
    """Lines around each layer."""
    infill: Annotated[float, tyro.conf.arg(metavar="SHARE")] = 0.15
    """Part of the inside that is filled, 0 to 1."""
    play: Annotated[float, tyro.conf.arg(metavar="MM")] = 0.2
    """Play on each side between what goes together, mm; the gauges measure it."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing is read; by default the description's own."""
    seed: int = 0
    """Random seed."""
    json: bool = False
    """Print package.json instead of words."""
    quiet: bool = False
    """Show no progress."""
