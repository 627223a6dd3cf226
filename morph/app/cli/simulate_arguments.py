"""What `morph simulate` takes; light, so that `morph --help` answers at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from morph.app.cli.options import Base, File, Folder, Many, Name, Posture, unset


@dataclass(frozen=True, kw_only=True)
class Simulate:
    """Let a robot move under effects, and record, film or show what it does.

    Example: morph simulate pendulum --start hinge=1 --effect viscous_friction@hinge:b=0.1
    --out run.parquet --video run.mp4
    """

    robot: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, xacro, MJCF, assembly.toml), a robot folder, or a name on the shelf."""
    policy: Annotated[str | None, unset("DIR")] = None
    """Folder of the policy that commands its actuators; without one they are told zero."""
    effect: Annotated[Many, unset("NAME@WHERE:PARAM=VALUE,...")] = ()
    """Physics that acts on it, as `morph list effects` names it; may be repeated."""
    effects: Annotated[str | None, unset("TOML")] = None
    """File of effects, such as the corrected.toml of a diagnosis."""
    world: Name = None
    """Where it moves: water, salt_water, hard_floor, rubber_on_wood, pla_on_carpet."""
    seconds: float = 5.0
    """How long it moves."""
    step: float = 0.002
    """Seconds a step; less where the simulation is stiff."""
    integrator: Annotated[Literal["implicitfast", "rk4"] | None, unset("{implicitfast,rk4}")] = None
    """How it steps; by default rk4 for what swims freely, else implicitfast."""
    noise: Annotated[float, tyro.conf.arg(metavar="SIGMA")] = 0.0
    """Standard deviation of the noise of recorded positions and orientations, rad or m; with it
    velocities are not recorded."""
    posture: Posture = None
    """Where it starts: a keyframe, standing, rest (as described), a TOML file of JOINT = 0.5 or
    an SRDF file; on a floor by default a keyframe such as home, else standing, else rest."""
    start: Annotated[Many, unset("NAME=VALUE")] = ()
    """What differs from the posture: JOINT=0.5 (rad or m), hull.position.z=1; may be repeated."""
    speed: Annotated[Many, unset("NAME=VALUE")] = ()
    """How fast: JOINT=2 (per s), hull.linear_velocity.x=0.5; may be repeated."""
    command: Annotated[Many, unset("NAME=VALUE")] = ()
    """What an actuator is told all along, in its own unit; may be repeated."""
    commands: Annotated[Path | None, unset("FILE")] = None
    """Recording whose commands it is told from its start on, such as a run of `morph excite`."""
    only: Name = None
    """Name of the episode of --commands, where these hold several."""
    out: File = None
    """Recording to write: .parquet, .csv, .csv.gz or .npz."""
    video: File = None
    """Film to write: .mp4 or .gif."""
    view: bool = False
    """Show it in the browser, until interrupted."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing is read; by default the description's own."""
    json: bool = False
    """Print a summary as JSON, by the schema morph.simulation/1."""
    quiet: bool = False
    """Show no progress."""
