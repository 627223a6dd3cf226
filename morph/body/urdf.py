"""Reading a body from URDF, which has no actuators: the card's motors give them."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import mujoco

from morph.body.card import Card, Motor
from morph.body.normal import refused, robot_of
from morph.body.robot import Robot
from morph.body.servo import SERVOS, servo
from morph.errors import RobotError

MOVING = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
"""The joints that a motor can drive."""


def read_urdf(path: Path, card: Card | None = None) -> Robot:
    """Return the robot that a URDF file describes.

    The actuators are those of the card; without a card, each moving joint has
    an ideal motor that bears its name.

    Raises:
        RobotError: MuJoCo cannot read or compile the file, or a motor of the
            card names a joint or a model that there is not.
    """
    try:
        tree = ElementTree.fromstring(path.read_bytes())
        _keep_everything(tree)
        # MuJoCo finds meshes beside the file that it reads; the text has no
        # place, so robot_of reads them instead.
        spec = mujoco.MjSpec.from_string(ElementTree.tostring(tree, encoding="unicode"))
    except (ElementTree.ParseError, ValueError) as error:
        raise refused(error, path) from error
    if card and card.base != "fixed":
        spec.worldbody.first_body().add_freejoint(name="root")
    joints = {joint.name: joint for joint in spec.joints if joint.type in MOVING}
    motors = card.motor if card and card.motor else tuple(Motor(actuator=name) for name in joints)
    for motor in motors:
        _add(spec, motor, joints, path)
    return robot_of(spec, path, card)


def _keep_everything(tree: ElementTree.Element) -> None:
    # By default MuJoCo drops a URDF's visual shapes, melts links without a
    # joint into their parents, and drops the folders of mesh files.
    extension = tree.find("mujoco")
    if extension is None:
        extension = ElementTree.SubElement(tree, "mujoco")
    compiler = extension.find("compiler")
    if compiler is None:
        compiler = ElementTree.SubElement(extension, "compiler")
    for key in ("discardvisual", "fusestatic", "strippath"):
        compiler.attrib.setdefault(key, "false")


def _add(spec: Any, motor: Motor, joints: dict[str, Any], path: Path) -> None:
    if motor.actuator not in joints:
        raise RobotError(
            f"the motor {motor.actuator!r} names no moving joint; there are {', '.join(joints)}",
            where=str(path.parent / "card.toml"),
            fix="name the motor as the joint it drives",
        )
    added = spec.add_actuator(
        name=motor.actuator, target=motor.actuator, trntype=mujoco.mjtTrn.mjTRN_JOINT
    )
    model = servo(motor.model)
    if model is not None:
        added.set_to_position(kp=model.kp, kv=model.kv)
        limit = motor.limit or model.limit
        added.forcelimited, added.forcerange = True, (-limit, limit)
        joints[motor.actuator].armature = model.armature
    elif motor.model == "ideal":
        added.set_to_motor()
        if motor.limit is not None:
            added.ctrllimited, added.ctrlrange = True, (-motor.limit, motor.limit)
    else:
        raise RobotError(
            f"no motor model is called {motor.model!r}",
            where=str(path.parent / "card.toml"),
            fix=f"use ideal or one of {', '.join(known.name for known in SERVOS)}",
        )
