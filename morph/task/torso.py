"""Bodies that stand, walk or swim: their torso, and how they stand at rest."""

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

BENT = 0.3
"""How far from its limits each joint of a stance is kept, rad, where there is room."""


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


def stance(robot: Robot) -> dict[str, float]:
    """Return where the joints of a planar walker with motors are as it stands; else nothing.

    What has servos or floats stands as it is described. What has motors alone would stand on
    straight legs, each knee at its limit: its joints are bent a little, soles flat on the
    floor where they were, trunk upright, and its centre of mass above the middle of the soles.
    """
    link = torso_of(robot)
    floats = any(joint.kind in {"free", "ball"} for joint in robot.joints)
    if link is None or floats or any(each.kind == "position" for each in robot.actuators):
        return {}
    from scipy.optimize import least_squares

    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    feet = [model.body(name).id for name in feet_of(robot)]
    if not feet:
        return {}
    flat = data.xmat[feet].copy()
    low = data.xpos[feet, 2].copy()
    joints = [robot.driven_by(each) for each in robot.actuators]
    driven = [model.joint(each.name).qposadr[0] for each in joints]
    limits = np.array([each.limits or (-9.0, 9.0) for each in joints])
    lean = _angles_of(robot, link, model)

    def off(position: Array) -> Array:
        data.qpos = position
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        middle = data.xipos[feet, 0].mean()
        bent = position[driven]
        short = np.maximum(0.0, limits[:, 0] + BENT - bent) + np.maximum(
            0.0, bent - limits[:, 1] + BENT
        )
        return np.concatenate(
            [
                10.0 * (data.xmat[feet] - flat).ravel(),
                10.0 * (data.xpos[feet, 2] - low),
                [10.0 * (data.subtree_com[0, 0] - middle)],
                10.0 * position[lean],
                short,
                0.01 * position,
            ]
        )

    # A step off the straight leg, at which the gradient of its height is zero.
    begin = model.qpos0.copy()
    begin[driven] += np.clip(0.0, limits[:, 0] + BENT, limits[:, 1] - BENT)
    result = least_squares(off, begin).x
    # To a tenth of a milliradian, which reads better and stands as well.
    return {
        joint.name: round(float(result[model.joint(joint.name).qposadr[0]]), 4) + 0.0
        for joint in robot.joints
        if joint.kind in {"hinge", "slide"}
    }


def feet_of(robot: Robot) -> tuple[str, ...]:
    """Return the links at the end of a leg, those that are lowest as the body is described."""
    return tuple(limb.end for limb in limbs_of(robot).feet)


def legs_of(robot: Robot) -> set[str]:
    """Return the joints between where the body branches and the feet."""
    return {joint for limb in limbs_of(robot).feet for joint in limb.joints}


def _angles_of(robot: Robot, link: str, model: Any) -> list[int]:
    return [
        int(model.joint(joint.name).qposadr[0])
        for joint in robot.joints
        if joint.link == link and joint.kind == "hinge"
    ]


def origin_of(robot: Robot, link: str, position: Mapping[str, float]) -> Array:
    """Return where a link's origin is in a posture, m, shape (3,)."""
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    for name, value in position.items():
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_kinematics(model, data)
    return np.array(data.xpos[model.body(link).id])
