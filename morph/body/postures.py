"""Postures of a robot by name: of its description, card and files, on its feet, as described."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

import mujoco

from morph.arrays import Array
from morph.body.limbs import torso_of
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.srdf import ENDING as SRDF
from morph.body.srdf import srdf_postures
from morph.body.standing import standing
from morph.body.surface import height_of, lowest_of
from morph.body.told import posed, posture_names, told
from morph.body.within_limits import within_limits
from morph.errors import RobotError
from morph.nearest import nearest
from morph.toml_file import load_toml

REST, STANDING = "rest", "standing"
"""As the description has it, and on its feet."""
ENDING, MOST_BYTES = ".toml", 100_000
"""What files of one posture end in, and the most bytes that one may have."""
USUAL = ("home", "stand", "standing", "half_sitting", "default")
"""What the posture in which a robot is ready is called, most usual first."""


def keyframes_of(robot: Robot, model: Any = None) -> dict[str, dict[str, float]]:
    """Return the postures of a robot's keyframes and card, as simulations are told to start.

    Keyframes are brought within the limits of joints, as these would throw it back.

    Args:
        robot: The robot.
        model: Its compiled `mujoco.MjModel`, where there is one already.

    Raises:
        RobotError: A file that its card names cannot be used.
    """
    model = spec_of(robot).compile() if model is None else model
    known = {
        model.key(at).name or f"keyframe {at + 1}": told(robot, model, pose)
        for at, pose in enumerate(_startable(robot, model, pose) for pose in model.key_qpos)
    }
    return known | card_postures(robot)


def card_postures(robot: Robot) -> dict[str, dict[str, float]]:
    """Return the postures that a robot's card names.

    Raises:
        RobotError: A file of theirs cannot be used.
    """
    if robot.card is None or robot.source is None:
        return {}
    folder, known = Path(robot.source).parent, posture_names(robot)
    srdf: dict[Path, dict[str, dict[str, float]]] = {}
    postures = {}
    for each in robot.card.posture:
        path = folder / each.file
        if _is(path, SRDF) and path not in srdf:
            srdf[path] = srdf_postures(path, robot)
        posture = _named(srdf[path], path, each.name) if path in srdf else _read(path)
        # A robot that was varied may lack some of them.
        postures[each.name] = {name: value for name, value in posture.items() if name in known}
    return postures


def check_card_postures(robot: Robot) -> None:
    """Check the postures that a robot's card names.

    Raises:
        RobotError: A file of theirs cannot be used, or names what the robot does not have.
    """
    card_postures(robot)
    if robot.card is None or robot.source is None:
        return
    known = posture_names(robot)
    for each in robot.card.posture:
        path = Path(robot.source).parent / each.file
        wrong = [] if _is(path, SRDF) else sorted(_read(path).keys() - known)
        if wrong:
            raise RobotError(
                f"posture {each.name!r} names {wrong[0]!r}, which {robot.name} does not have",
                where=str(path),
                fix=f"nearest: {nearest(wrong[0], known)}",
            )


def postured(robot: Robot, posture: str | None) -> Robot:
    """Return a robot that starts on floors in a posture of its own or of a file.

    Args:
        robot: The robot.
        posture: That of a keyframe or of its card, `standing`, `rest`, a TOML file that gives
            joints (rad or m) and channels of the base, such as `base.position.z`, or an SRDF
            file, with `:NAME` where it holds several. None changes nothing.

    Raises:
        RobotError: It has no such posture, or the file cannot be used.
    """
    if posture is None:
        return robot
    if posture == REST:
        return replace(robot, posture={})
    file, colon, name = posture.partition(f"{SRDF}:")
    if _is(Path(posture), ENDING):
        return replace(robot, posture=_read(Path(posture)))
    if colon or _is(Path(posture), SRDF):
        path = Path(f"{file}{SRDF}" if colon else posture)
        return replace(robot, posture=_named(srdf_postures(path, robot), path, name or None))
    known: dict[str, Mapping[str, float]] = dict(keyframes_of(robot))
    if posture not in known and posture == STANDING:
        found = standing(robot)
        if found is None:
            raise RobotError(
                "it has no feet to stand on", where=f"robot {robot.name}", fix=f"say {REST}"
            )
        known[STANDING] = found.position
    if posture not in known:
        names = (*known, STANDING, REST)
        raise RobotError(
            f"it has no posture {posture!r}",
            where=f"robot {robot.name}",
            fix=f"its postures are {nearest(posture, names)}; or give a file that ends in "
            f"{ENDING} or {SRDF}",
        )
    return replace(robot, posture=known[posture])


def posture_of(robot: Robot) -> Mapping[str, float]:
    """Return where tasks on a floor start, by joint, rad or m, and by channel of the base.

    It is the posture that the robot was given (`postured`), else the keyframe of a usual name,
    else on its feet, else as it is described, raised out of the floor, and within its limits.
    """
    if robot.posture is not None:
        return robot.posture
    known = keyframes_of(robot)
    usual = next((each for each in USUAL if each in known), None)
    if usual is not None:
        return known[usual] | _raised(robot, known[usual])
    found = standing(robot)
    if found is not None:
        return found.position
    rest = described(robot)
    return rest | _raised(robot, rest)


def described(robot: Robot) -> dict[str, float]:
    """Return what starts otherwise than it is described, as limits would throw it back.

    A closed chain would be torn joint by joint, and is left.
    """
    model: Any = spec_of(robot).compile()
    return told(robot, model, _startable(robot, model, model.qpos0))


def _startable(robot: Robot, model: Any, pose: Array) -> Array:
    return pose if robot.loops else within_limits(model, pose)


def _raised(robot: Robot, posture: Mapping[str, float]) -> dict[str, float]:
    """Return what lifts a robot out of the floor, where a posture does not say how high it is."""
    link = torso_of(robot)
    if link is None or f"{link}.position.z" in posture:
        return {}
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    pose = posed(robot, model, posture)
    data.qpos[:] = pose
    mujoco.mj_kinematics(model, data)
    body = int(model.body(link).id)
    low, found = lowest_of(model, data, body), height_of(model, data, body)
    if low is None or low >= 0.0 or found is None:
        return {}
    pose[found[0]] -= low / found[1]
    return told(robot, model, pose)


def _is(path: Path, ending: str) -> bool:
    return path.suffix.lower() == ending


def _named(known: Mapping[str, dict[str, float]], path: Path, name: str | None) -> dict[str, float]:
    """Return the posture of a name, else of a usual name, else the only one of a file."""
    usual = next((each for each in USUAL if each in known), None)
    named = name or usual or (next(iter(known)) if len(known) == 1 else None)
    if named is None or named not in known:
        raise RobotError(
            f"there is no posture {named!r}" if named else f"it holds {len(known)} postures",
            where=str(path),
            fix=f"say {path}:NAME, where NAME is {nearest(named or '', known)}"
            if known
            else "name an SRDF with a group_state of the robot's joints",
        )
    return known[named]


def _read(path: Path) -> dict[str, float]:
    try:
        table, _ = load_toml(path, MOST_BYTES)
    except (OSError, ValueError) as error:
        raise RobotError(
            f"the posture cannot be read: {error}",
            where=str(path),
            fix='write lines such as knee = 0.5 and "base.position.z" = 0.3',
        ) from error
    wrong = [name for name, value in table.items() if not _is_number(value)]
    if wrong:
        raise RobotError(
            f"{wrong[0]} is no finite number",
            where=str(path),
            fix='write lines such as knee = 0.5 and "base.position.z" = 0.3, quotes about dots',
        )
    return {name: float(value) for name, value in table.items()}


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, (int, float)) and not isinstance(value, bool) and isfinite(value)
    except OverflowError:
        return False
