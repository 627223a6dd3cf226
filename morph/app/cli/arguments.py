"""What each command takes; light, so that `morph --help` answers at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from morph.app.cli.options import Base, File, Folder, Horizon, Many, Name, Names, Posture, unset

BUDGET = 600.0
"""Seconds that a diagnosis may take if nothing else is given."""


@dataclass(frozen=True, kw_only=True)
class Diagnose:
    """Say where a robot's description and its recordings part, and what physics was left out.

    Example: morph diagnose double_pendulum rig.toml --held-out run_03 run_05 --out report
    """

    robot: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, xacro, MJCF, assembly.toml), a robot folder, or a name on the shelf."""
    recordings: Annotated[tyro.conf.Positional[tuple[Path, ...]], unset("RECORDING ...")]
    """Files or folders: CSV, NPZ, Parquet, HDF5, MCAP, ROS 2 bags; or a recording.toml."""
    out: Path
    """Folder for diagnosis.json, report.html and the corrected model."""
    held_out: Names = ()
    """Recordings, or names of episodes, kept for testing: scored once, after the model was chosen;
    by default the last quarter."""
    only: Names = ()
    """Names of the episodes to fit; by default all that are not held out."""
    horizon: Horizon = "1.0"
    """Seconds of the rollouts on which errors are reported, or `full` for whole episodes."""
    vary: Annotated[tuple[str, ...], unset("NAME=FRACTION ...")] = ()
    """By how much the description's own parameters may be wrong: mass=0.3 of all links,
    mass:pole=0 of one; com, inertia, gain, and joint for constants of joints."""
    root: Folder = None
    """Folder that a recording.toml's files are relative to, instead of its own `root`."""
    budget: Annotated[float, tyro.conf.arg(metavar="SECONDS")] = BUDGET
    """Seconds, or inf, after which the best answer so far is written (exit status 3), as after
    Ctrl-C."""
    world: Name = None
    """The floor that it stood on, where the description has none: as `morph simulate --world`."""
    seed: int = 0
    """Random seed."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing of the description is read; by default its own."""
    json: bool = False
    """Print diagnosis.json instead of words."""
    quiet: bool = False
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class Compare:
    """Say in seconds where, when and how much a description and its recordings part.

    Nothing is fitted and nothing named: that is `morph diagnose`.

    Example: morph compare double_pendulum rig.toml
    """

    robot: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, xacro, MJCF, assembly.toml), a robot folder, or a name on the shelf."""
    recordings: Annotated[tyro.conf.Positional[tuple[Path, ...]], unset("RECORDING ...")]
    """Files or folders: CSV, NPZ, Parquet, HDF5, MCAP, ROS 2 bags; or a recording.toml."""
    horizon: Horizon = "1.0"
    """Seconds of the rollouts, each from the state as recorded, or `full` for whole recordings."""
    world: Name = None
    """Where it moved: as `morph simulate --world`."""
    effects: Annotated[str | None, unset("TOML")] = None
    """File of effects that act, such as the corrected.toml of a diagnosis."""
    root: Folder = None
    """Folder that a recording.toml's files are relative to, instead of its own `root`."""
    state: Annotated[Path | None, unset("FILE")] = None
    """Write the view of the worst moment there, for `morph view --state FILE`."""
    html: Annotated[Path | None, unset("FILE")] = None
    """Write that view as one page that opens without a network."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing of the description is read; by default its own."""
    json: bool = False
    """Print JSON, by the schema morph.comparison/1."""
    quiet: bool = False
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class List:
    """List what morph knows.

    Example: morph list effects
    """

    what: tyro.conf.Positional[
        Literal["robots", "effects", "tasks", "searches", "printers", "materials"]
    ]
    """robots: the shelf. effects: the physics that can be simulated and found. tasks: what a
    robot can be asked to learn. searches: the ways to learn it. printers, materials: what
    `morph print` knows."""
    json: bool = False
    """Print JSON."""


@dataclass(frozen=True, kw_only=True)
class Inspect:
    """Show what a robot is, what is wrong with its description, and what was done about it.

    Exit status 0: ok or repaired; 2: refused, or with --strict anything but ok.

    Example: morph inspect robots/poppy.urdf --base floating
    """

    robot: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, xacro, MJCF, assembly.toml), a robot folder, or a name on the shelf."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing is read; by default the description's own."""
    strict: bool = False
    """Exit with status 2 if anything was repaired."""
    picture: File = None
    """Draw it in the posture in which tasks on a floor start, into a .png file."""
    posture: Posture = None
    """Draw it in another posture: as `morph simulate --posture`."""
    json: bool = False
    """Print JSON, by the schema morph.inspection/1."""


@dataclass(frozen=True, kw_only=True)
class Convert:
    """Write a clean description of a robot that MuJoCo, Pinocchio and yourdfpy load alike.

    Example: morph convert poppy.urdf --to mjcf --servo MX-28 --out poppy
    """

    robot: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, xacro, MJCF, assembly.toml), a robot folder, or a name on the shelf."""
    to: Literal["mjcf", "urdf"]
    """The format to write."""
    out: Annotated[str, tyro.conf.arg(metavar="PATH")]
    """Folder for the description, its meshes and what was found."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing is read; by default the description's own."""
    servo: Annotated[Many, unset("[JOINT:]SERVO")] = ()
    """Servo at a joint, or at every driven one: a name such as MX-28, or kp=20,kv=1,limit=6,
    armature=0.01,friction=0.1. May be repeated."""
    pieces: bool = False
    """Cut collision meshes into convex pieces; seconds to minutes, kept for the next time."""
    json: bool = False
    """Print what was written as JSON, by the schema morph.conversion/1."""


@dataclass(frozen=True, kw_only=True)
class Learn:
    """Learn a policy for a task, and report how it was found and how good it is.

    The same command again goes on where it was interrupted; with more trials it goes on further.
    Exit status 3: the search did not succeed; its best policy is written and marked so.

    Example: morph learn swing-up --robot cartpole --search ddp --out learned
    """

    task: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="TASK")]
    """What is to be done: a name from `morph list tasks`."""
    robot: Annotated[str, tyro.conf.arg(metavar="ROBOT")]
    """A description (URDF, xacro, MJCF, assembly.toml), a robot folder, or a name on the shelf."""
    out: Annotated[str, tyro.conf.arg(metavar="DIR")]
    """Folder for the policy, report.html, record.json and the state of the search."""
    search: Name = None
    """A name from `morph list searches`; by default one that suits the task."""
    posture: Posture = None
    """Where it stands at first, of tasks on a floor: as `morph simulate --posture`."""
    trials: Annotated[int | None, unset("N")] = None
    """Most trials, generations or rounds; by default the search's own number."""
    seed: int = 0
    """Random seed."""
    world: Name = None
    """Where it learns, if not where the task says: as `morph simulate --world`."""
    effect: Annotated[Many, unset("NAME@WHERE:PARAM=VALUE,...")] = ()
    """Physics that acts on it, as `morph list effects` names it; may be repeated."""
    effects: Annotated[str | None, unset("TOML")] = None
    """File of effects, such as the corrected.toml of a diagnosis."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing is read; by default the description's own."""
    fresh: bool = False
    """Begin anew in a folder that holds an earlier search."""
    json: bool = False
    """Print record.json instead of words."""
    quiet: bool = False
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class Loop:
    """Carry a policy to a target: try it, say what the model lacks, repair it, and try again.

    The target is one of: a simulation that differs by --change, --effect or --effects; one that
    differs by what is sealed; a live one; or recordings of one, which are only diagnosed.
    The same command again goes on at the trial it was in. Exit status 3: the task was not done on
    the target, or it stopped short; the best policy so far is written, and says so.

    Example: morph loop swing-up --robot cartpole --policy learned/policy --sealed 7 --out carried
    """

    task: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="TASK")]
    """What is to be done: a name from `morph list tasks`."""
    robot: Annotated[str, tyro.conf.arg(metavar="ROBOT")]
    """The source: a description, a robot folder, or a name on the shelf."""
    out: Annotated[str, tyro.conf.arg(metavar="DIR")]
    """Folder for the policy, transfer.json, report.html, the corrected model and the trials."""
    policy: Annotated[str | None, unset("DIR")] = None
    """Folder of the source's policy; without one it is learned first, on the source."""
    change: Annotated[Many, unset("FIGURE=FACTOR")] = ()
    """A figure in which the target differs: length:pole=2, weight:cart=0.5; may be repeated."""
    effect: Annotated[Many, unset("NAME@WHERE:PARAM=VALUE,...")] = ()
    """Physics that acts on the target alone, as `morph list effects` names it; may be repeated."""
    effects: Annotated[str | None, unset("TOML")] = None
    """File of effects that act on the target alone."""
    sealed: Annotated[int | None, unset("SEED")] = None
    """Draw what differs from this seed, and tell nobody before the end."""
    live: Annotated[str | None, unset("COMMAND")] = None
    """Program to start that speaks for the target in JSON lines (docs/live.md)."""
    limit: Annotated[Many, unset("WHAT:NAME=VALUE")] = ()
    """Of a live target: command:ACTUATOR=LOW..HIGH or position:JOINT=LOW..HIGH; and
    rate:ACTUATOR=MOST or speed:JOINT=MOST, per s; may be repeated."""
    stop_file: File = None
    """A file that stops a live target by being there."""
    recorded: Annotated[tuple[Path, ...], unset("RECORDING ...")] = ()
    """Recordings of the target: what differs is said, and nothing is tried or learned."""
    trials: Annotated[int, tyro.conf.arg(metavar="N")] = 5
    """Most trials on the target, that of the source's policy included."""
    seed: int = 0
    """Random seed of all but the sealed truth."""
    world: Name = None
    """Where both are, if not where the task says: as `morph simulate --world`."""
    base: Base = None
    """How it stands in the world, where the description does not say."""
    folder: Folder = None
    """Folder outside which nothing is read; by default the description's own."""
    fresh: bool = False
    """Begin anew in a folder that holds an earlier loop."""
    json: bool = False
    """Print transfer.json instead of words."""
    quiet: bool = False
    """Show no progress."""
