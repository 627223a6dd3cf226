"""Bodies that stand, walk or swim: their torso, their feet and their legs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.limbs import limbs_of, torso_of
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import TaskError
from morph.sim.start import started


def torso(robot: Robot, task: str) -> str:
    """Return the link that moves freely, which a task asks to go somewhere.

    Raises:
        TaskError: No link does: the body is held to the world.
    """
    result = torso_of(robot)
    if result is None:
        raise TaskError(
            "no link of it moves freely: it is held to the world",
            where=f"task {task} of {robot.name}",
            fix="give a body that can go somewhere, such as quadruped_printed",
        )
    return result


def feet_of(robot: Robot) -> tuple[str, ...]:
    """Return the links at the end of a leg, those that are lowest as the body is described."""
    return tuple(limb.end for limb in limbs_of(robot).feet)


def legs_of(robot: Robot) -> set[str]:
    """Return the joints between where the body branches and the feet."""
    return {joint for limb in limbs_of(robot).feet for joint in limb.joints}


def origin_of(robot: Robot, link: str, position: Mapping[str, float]) -> Array:
    """Return where a link's origin is in a posture, m, shape (3,)."""
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    data.qpos, _ = started(robot, model, position)
    mujoco.mj_kinematics(model, data)
    return np.array(data.xpos[model.body(link).id])
