"""Postures in SRDF, the file beside a URDF in which MoveIt and Pinocchio keep them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot, isfinite
from pathlib import Path

from morph.body.robot import Joint, Robot
from morph.body.told import PLACES
from morph.body.xml import MOST_BYTES, Element, parse
from morph.errors import RobotError
from morph.regular_file import read_regular

ENDING = ".srdf"
"""What such files end in."""
TURNS = ("x", "y", "z", "w")
"""Quaternions as Pinocchio writes them."""


def srdf_postures(path: Path, robot: Robot) -> dict[str, dict[str, float]]:
    """Return the postures (`group_state`) of a file by name, as simulations are told to start.

    An SRDF serves all variants of a robot: joints that this one does not have, and a base that
    it bolts, are passed over.

    Args:
        path: The file.
        robot: The robot that it is for.

    Returns:
        Joints, rad or m, and channels of the base, m and unit quaternions, by posture. Those
        that name no joint of the robot are left out.

    Raises:
        RobotError: The file cannot be read, is no SRDF, or gives a joint what it cannot have.
    """
    try:
        root = parse(read_regular(path, MOST_BYTES), str(path))
    except OSError as error:
        raise RobotError(
            f"the postures cannot be read: {error.strerror or error}",
            where=str(path),
            fix="name an SRDF file that exists",
        ) from error
    if root.tag != "robot":
        raise RobotError(
            f"is no SRDF: it begins with <{root.tag}>", where=root.place, fix="name an SRDF file"
        )
    known = {joint.name: joint for joint in robot.joints}
    free = [joint for joint in robot.joints if joint.kind == "free"]
    postures: dict[str, dict[str, float]] = {}
    for state in root.children("group_state"):
        name = state.get("name", "").strip()
        postures.setdefault(name, {}).update(_posture(state, known, free))
    return {name: posture for name, posture in postures.items() if name and posture}


def _posture(state: Element, known: Mapping[str, Joint], free: Sequence[Joint]) -> dict[str, float]:
    posture: dict[str, float] = {}
    for element in state.children("joint"):
        values = _values(element)
        # The joint between world and base has a name in the SRDF alone.
        base = free[0] if len(values) == 7 and len(free) == 1 else None
        joint = known.get(element.get("name", ""), base)
        if joint is not None:
            posture |= _placed(joint, values, element)
    return posture


def _values(element: Element) -> list[float]:
    try:
        values = [float(word) for word in element.get("value", "").split()]
    except ValueError:
        values = []
    if not values or not all(map(isfinite, values)):
        raise RobotError(
            f"joint {element.get('name', '')[:80]!r} has the value "
            f"{element.get('value', '')[:80]!r}",
            where=element.place,
            fix="give it a finite number, rad or m; a floating base x y z and a quaternion x y z w",
        )
    return values


def _placed(joint: Joint, values: list[float], element: Element) -> dict[str, float]:
    if joint.kind in {"hinge", "slide"} and len(values) == 1:
        return {joint.name: values[0]}
    part = joint.link if joint.kind == "free" else joint.name
    names = [f"{part}.orientation.{axis}" for axis in TURNS]
    if joint.kind == "free":
        names = [*(f"{part}.position.{axis}" for axis in PLACES), *names]
    turned = values[-len(TURNS) :]
    size = hypot(*turned)
    if len(values) != len(names) or not 0.9 < size < 1.1:
        raise RobotError(
            f"joint {joint.name!r} is a {joint.kind} and has {len(values)} values"
            + ("" if len(values) != len(names) else f", a quaternion of length {size:.3g}"),
            where=element.place,
            fix="give a hinge or slide one value, a floating base x y z and a unit quaternion "
            "x y z w",
        )
    unit = [value / size for value in turned]
    return dict(zip(names, [*values[: -len(TURNS)], *unit], strict=True))
