"""A Robot in Pinocchio: a second opinion on what MuJoCo computes."""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from morph.body.ground import flatten
from morph.body.quiet import silent
from morph.body.robot import Robot
from morph.errors import RobotError


def twin_of(robot: Robot) -> Any:
    """Return a robot as a `pinocchio.Model`.

    Pinocchio reads the MJCF with a parser of its own and computes with
    algorithms of its own (Carpentier et al. 2019, SII). It knows the rigid
    bodies, the armature and gravity; it knows no friction, contact, actuator or
    height field, which is ground.

    Raises:
        RobotError: Pinocchio cannot read the description.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.xml"
        for name, content in robot.assets.items():
            (Path(folder) / name).write_bytes(content)
        try:
            tree = ElementTree.fromstring(robot.mjcf)
            flatten(tree)
            path.write_bytes(ElementTree.tostring(tree))
            model = pinocchio.buildModelFromMJCF(str(path))
        except (ElementTree.ParseError, ValueError, RuntimeError) as error:
            raise RobotError(
                f"Pinocchio cannot read it: {error}",
                where=f"robot {robot.name}",
                fix="describe it without the element that Pinocchio names",
            ) from error
    # Pinocchio's parser leaves the option element unread.
    option = tree.find("option")
    gravity = "0 0 -9.81" if option is None else option.get("gravity", "0 0 -9.81")
    model.gravity.linear = np.array(gravity.split(), dtype=float)
    return model


def twin_of_source(robot: Robot) -> Any:
    """Return Pinocchio's own reading of the file that a robot came from.

    Of a URDF it is the file itself, expanded if it is xacro, with a free root if
    the robot floats; of all else, and of one on a board, what morph made of it.

    Raises:
        RobotError: Pinocchio cannot read it.
    """
    if robot.source is None or robot.source.suffix.lower() not in (".urdf", ".xacro"):
        return twin_of(robot)
    from morph.body.paths import Files
    from morph.body.source import source_tree

    tree = source_tree(robot.source, Files(robot.source))
    text = ElementTree.tostring(tree, encoding="unicode")
    # A free root that the file states itself is in Pinocchio's reading already.
    stated = {joint.get("name") for joint in tree.children("joint")}
    free = [joint.name for joint in robot.joints if joint.kind == "free"]
    floats = any(name not in stated for name in free)
    first = robot.joints[0] if robot.joints else None
    if first is not None and first.kind == "slide" and first.name not in stated:
        return twin_of(robot)  # It stands on a board, of which the file knows nothing.
    root = (pinocchio.JointModelFreeFlyer(),) if floats else ()
    try:
        with silent():
            return pinocchio.buildModelFromXML(text, *root)
    except (ValueError, RuntimeError) as error:
        raise RobotError(
            f"Pinocchio cannot read it: {error}",
            where=str(robot.source),
            fix="correct what Pinocchio names",
        ) from error
