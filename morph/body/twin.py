"""A Robot in Pinocchio: a second opinion on what MuJoCo computes."""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from morph.body.robot import Robot
from morph.errors import RobotError


def twin_of(robot: Robot) -> Any:
    """Return a robot as a `pinocchio.Model`.

    Pinocchio reads the MJCF with a parser of its own and computes with
    algorithms of its own (Carpentier et al. 2019, SII). It knows the rigid
    bodies, the armature and gravity; it knows no friction, contact or actuator.

    Raises:
        RobotError: Pinocchio cannot read the description.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.xml"
        path.write_text(robot.mjcf)
        for name, content in robot.assets.items():
            (Path(folder) / name).write_bytes(content)
        try:
            model = pinocchio.buildModelFromMJCF(str(path))
        except (ValueError, RuntimeError) as error:
            raise RobotError(
                f"Pinocchio cannot read it: {error}",
                where=f"robot {robot.name}",
                fix="describe it without the element that Pinocchio names",
            ) from error
    # Pinocchio's parser leaves the option element unread.
    option = ElementTree.fromstring(robot.mjcf).find("option")
    gravity = "0 0 -9.81" if option is None else option.get("gravity", "0 0 -9.81")
    model.gravity.linear = np.array(gravity.split(), dtype=float)
    return model
