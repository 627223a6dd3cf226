"""From a robot and operations to a robot, with where it came from."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from morph.body.card import Card, Checks
from morph.body.normal import robot_of
from morph.body.robot import Mimic, Robot
from morph.body.spec import bare_spec
from morph.body.vary.operation import Operation
from morph.body.vary.unhook import inventory
from morph.errors import RobotError
from morph.files import sha256


def vary(robot: Robot, *operations: Operation) -> Robot:
    """Return a robot after operations, applied in order; the given one is not changed.

    Its name tells the operations, its hash is of the first robot's and theirs.
    It keeps its card, less what no longer holds: the checks, the motors of
    actuators that are gone, and parameters of links that are gone.

    Raises:
        RobotError: An operation names a part that is not there or cannot be
            changed so, or MuJoCo cannot use what comes of it.
    """
    if not operations:
        return robot
    spec = bare_spec(robot)
    spec.modelname = robot.name
    for operation in operations:
        operation.apply(spec)
    name = "+".join((robot.name, *map(str, operations)))
    origin = robot.sha256 or sha256(robot.mjcf)
    digest = sha256(origin, *(repr(each) for each in operations))
    return edited(robot, spec, name, digest)


def edited(robot: Robot, spec: Any, name: str, digest: str) -> Robot:
    """Return a robot as an edited `mujoco.MjSpec` of it describes; the spec is used up.

    Raises:
        RobotError: MuJoCo cannot use it.
    """
    return _remembering(rebuilt(spec, robot, name, digest), robot)


def removed(robot: Robot, *operations: Operation) -> tuple[str, ...]:
    """Return what operations take out of a robot, such as `actuator 'slide'`, in order.

    Raises:
        RobotError: As `vary` does.
    """
    spec = bare_spec(robot)
    spec.modelname = robot.name
    before = inventory(spec)
    for operation in operations:
        operation.apply(spec)
    after = set(inventory(spec))
    return tuple(part for part in before if part not in after)


def rebuilt(spec: Any, robot: Robot, name: str, digest: str) -> Robot:
    """Return the Robot that an edited spec of another robot describes; the spec is used up.

    Raises:
        RobotError: MuJoCo cannot use it.
    """
    spec.modelname = name
    with tempfile.TemporaryDirectory() as folder:
        # robot_of hashes a description's file: a varied body has none of its own.
        place = Path(folder) / "robot.xml"
        place.write_text(robot.mjcf)
        try:
            result = robot_of(spec, place, None, dict(robot.assets))
        except RobotError as error:
            raise RobotError(error.what, where=f"robot {name}", fix=error.fix) from error
    actuators = {actuator.name for actuator in result.actuators}
    links = {link.name for link in result.links}
    joints = {joint.name for joint in result.joints}
    return replace(
        result,
        name=name,
        source=robot.source,
        sha256=digest,
        card=_card(robot.card, actuators.__contains__, (links | joints | {"*"}).__contains__),
    )


def _remembering(varied: Robot, robot: Robot) -> Robot:
    # What the importer knows and MJCF cannot hold.
    links = {link.name: link for link in robot.links}
    joints = {joint.name: joint for joint in robot.joints}
    left = {joint.name for joint in varied.joints}
    return replace(
        varied,
        findings=robot.findings,
        links=tuple(
            replace(link, inertia_from=links[link.name].inertia_from)
            if link.name in links
            else link
            for link in varied.links
        ),
        joints=tuple(
            replace(joint, velocity=known.velocity, mimic=_kept(known.mimic, left))
            if (known := joints.get(joint.name)) is not None
            else joint
            for joint in varied.joints
        ),
    )


def _kept(mimic: Mimic | None, joints: set[str]) -> Mimic | None:
    return mimic if mimic is not None and mimic.joint in joints else None


def _card(
    card: Card | None, has_actuator: Callable[[str], bool], has_part: Callable[[str], bool]
) -> Card | None:
    if card is None:
        return None
    return replace(
        card,
        checks=Checks(),
        motor=tuple(motor for motor in card.motor if has_actuator(motor.actuator)),
        parameter=tuple(each for each in card.parameter if has_part(each.link)),
    )
