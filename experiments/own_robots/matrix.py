"""One robot through every command, in the order in which a user would give them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

from experiments.own_robots.absurd import absurd_motion, absurd_policy
from experiments.own_robots.applies import abilities
from experiments.own_robots.outcome import Outcome, outcome
from experiments.own_robots.pushed import stands_pushed
from morph.arrays import JSON
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MorphError
from morph.policy_transfer.balancers import PUSHED

COMMANDS = (
    "inspect", "convert", "simulate", "hold", "stand", "walk", "reach", "view", "diagnose",
    "align", "print",
)  # fmt: skip
"""Columns of the matrix; `walk` is `swim` of what floats without feet."""
SECONDS = {
    "inspect": 30.0, "convert": 60.0, "simulate": 60.0, "hold": 60.0, "stand": 60.0,
    "walk": 300.0, "reach": 30.0, "view": 60.0, "diagnose": 240.0, "align": 120.0, "print": 180.0,
}  # fmt: skip
"""CPU seconds that each command is to take."""
PATIENCE = 3.0
"""Times as long it may take: a machine may be slow."""
FLOOR = "hard_floor"
CONVERTED = "../convert/converted/robot.xml"
"""What `convert` writes, as seen from the folder of another command."""
LEARNED = ("hold", "stand", "walk", "reach")
"""Commands that learn a policy."""


def row(name: str, path: str, out: str, commands: Sequence[str] = COMMANDS) -> JSON:
    """Return what becomes of each command for one robot.

    Args:
        name: What the study calls it.
        path: Its description.
        out: Folder for what the commands write.
        commands: Those that are run, where they apply; `diagnose` reads what `simulate`
            wrote, `align` what `convert` wrote.
    """
    folder = Path(out) / name
    robot, described = _robot(Path(path))
    able = None if robot is None else abilities(robot)
    applicable = {"inspect", "convert"} if able is None else able.applicable
    swims = able is not None and able.floating and able.feet < 2
    results = {}
    for command in COMMANDS:
        if command not in applicable or command not in commands:
            continue
        words, most = _words(command, path, robot, swims=swims), PATIENCE * SECONDS[command]
        # `align` takes two bodies: it reads what `convert` made of this one.
        options = [] if command == "align" else described
        each = outcome([*words, *options], folder=folder / command, seconds=most)
        results[command] = _judged(command, each, folder, Path(path), described, robot)
        if each.kind in ("refused", "short") and each.fix:
            again = [*words, *options, *each.fix]
            after = outcome(again, folder=folder / f"{command}_fixed", seconds=most)
            results[command]["fixed"] = after.kind
    return {
        "robot": name,
        "abilities": None if able is None else asdict(able),
        "commands": results,
    }


def _robot(path: Path) -> tuple[Robot | None, list[str]]:
    """Return a robot, and the options under which it is read: with legs as one that floats."""
    try:
        robot = load(path)
    except MorphError:
        return None, []
    if path.suffix.lower() == ".urdf" and abilities(robot).arms >= 2:
        loose = load(path, base="floating")
        if abilities(loose).feet >= 2:
            return loose, ["--base", "floating"]
    return robot, []


def _words(command: str, path: str, robot: Robot | None, *, swims: bool) -> list[str]:
    told = ["--quiet", "--json"]
    floats = robot is not None and any(joint.kind == "free" for joint in robot.joints)
    floor = ["--world", FLOOR] if floats and not swims else []
    written = "../simulate/run.parquet"
    return {
        "inspect": ["inspect", path, "--json"],
        "convert": ["convert", path, "--to", "mjcf", "--out", "converted", "--json"],
        "simulate": ["simulate", path, "--seconds", "4", *floor, "--out", "run.parquet", *told],
        "hold": ["learn", "hold", "--robot", path, "--out", "learned", *told],
        "stand": ["learn", "stand", "--robot", path, "--out", "learned", *told],
        "walk": ["learn", "swim" if swims else "walk", "--robot", path, "--out", "learned", *told],
        "reach": ["learn", "reach", "--robot", path, "--out", "learned", *told],
        "view": ["view", path, "--html", "view.html", "--quiet"],
        "diagnose": ["diagnose", path, written, *floor, "--budget", "60", "--out", "report", *told],
        "align": ["align", _nearest(robot), CONVERTED, "--out", "aligned", *told],
        "print": [
            *("print", path, "--printer", "mk4", "--material", "pla", "--slicer", "none"),
            *("--out", "package", *told),
        ],
    }[command]


def _nearest(robot: Robot | None) -> str:
    """Return the body that can balance and has as many driven joints, or nearly."""
    count = 0 if robot is None else len(robot.driven)
    known = {name: len(load(name).driven) for name in PUSHED}
    return min(known, key=lambda name: (abs(known[name] - count), name))


def _judged(
    command: str, each: Outcome, folder: Path, path: Path, described: list[str], robot: Robot | None
) -> JSON:
    """Return an outcome as data, after what cannot be has been looked for."""
    absurd: list[str] = []
    recording = folder / "simulate" / "run.parquet"
    if command == "simulate" and recording.exists() and robot is not None:
        floats = any(joint.kind == "free" for joint in robot.joints)
        base = described[1] if described else None
        absurd = absurd_motion(
            path, recording, base=base, folder=None, floor=FLOOR if floats else None
        )
    if command in LEARNED and each.record is not None:
        absurd = absurd_policy(each.record)
    each = replace(each, kind="absurd", message="; ".join(absurd)) if absurd else each
    learned = {"controls": each.record["controls"]} if command in LEARNED and each.record else {}
    if command == "stand" and each.kind == "works":
        policy, base = folder / command / "learned" / "policy", described[1] if described else None
        learned["pushed"] = stands_pushed(path, policy, base=base, floor=FLOOR)
    return {
        **learned,
        "kind": each.kind,
        "command": each.command,
        "message": each.message[-600:],
        "cpu_s": round(each.seconds, 2),
        "in_time": each.seconds <= SECONDS[command],
        "memory_gb": round(each.memory / 1e9, 3),
        "fix": list(each.fix),
    }
