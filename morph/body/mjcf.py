"""Reading a body from MJCF."""

from __future__ import annotations

from pathlib import Path

import mujoco

from morph.body.card import Card
from morph.body.normal import refused, robot_of
from morph.body.robot import Robot


def read_mjcf(path: Path, card: Card | None = None) -> Robot:
    """Return the robot that an MJCF file describes.

    Raises:
        RobotError: MuJoCo cannot read or compile the file.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise refused(error, path) from error
    return robot_of(spec, path, card)
