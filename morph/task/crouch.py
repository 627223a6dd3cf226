"""Standing on bent knees: where a walker's joints are, soles flat and its weight above them."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import TaskError
from morph.sim.start import started
from morph.task.torso import feet_of, torso

TOLERANCE = 1e-3
"""How far from flat soles and a weight above them a posture may be, rad or m."""


def crouch(robot: Robot, bends: dict[str, float], *, task: str = "walk") -> dict[str, float]:
    """Return the posture in which some joints are bent so far and the body stands on flat soles.

    The other joints between the torso and the feet that turn about the same axis are placed so
    that the soles are as they are described and the centre of mass is above their middle; the
    torso stays upright, and comes as low as the legs become short.

    Args:
        robot: A floating body whose soles are flat as it is described.
        bends: Joints of its legs and how far each is bent, rad, such as both knees.
        task: What it is for, for messages.

    Raises:
        TaskError: No joint is left to place, or the body cannot stand so.
    """
    from scipy.optimize import least_squares

    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    feet = [model.body(name).id for name in feet_of(robot)]
    trunk = model.body(torso(robot, task)).id
    data.qpos = started(robot, model, {}, {})[0]
    mujoco.mj_forward(model, data)
    flat, low = data.xmat[feet].copy(), data.xpos[feet, 2].mean()
    turned = [joint for joint in _legs(model, feet, trunk) if _along(model, data, joint, bends)]
    free = [joint for joint in turned if model.joint(joint).name not in bends]
    if not free:
        raise TaskError(
            f"beside {', '.join(bends)} no joint of its legs turns about the same axis",
            where=f"task {task} of {robot.name}",
            fix="bend fewer joints, such as the knees alone",
        )
    places = [int(model.jnt_qposadr[joint]) for joint in free]
    for name, bend in bends.items():
        data.qpos[model.joint(name).qposadr[0]] = bend

    def off(angles: Array) -> Array:
        data.qpos[places] = angles
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        middle = np.mean([_middle(model, data, foot) for foot in feet], axis=0)
        lean = (data.subtree_com[trunk] - middle)[:2]
        return np.concatenate([(data.xmat[feet] - flat).ravel(), 5.0 * lean, 1e-4 * angles])

    result = least_squares(off, np.zeros(len(free)))
    if np.abs(off(result.x)[: -len(free)]).max() > 5.0 * TOLERANCE:
        raise TaskError(
            f"bent so, it leaves {np.abs(off(result.x)).max():.3g} of flat soles under its weight",
            where=f"task {task} of {robot.name}",
            fix="bend both legs alike, and less",
        )
    posture = dict(bends) | {
        str(model.joint(joint).name): round(float(angle), 4) + 0.0
        for joint, angle in zip(free, result.x, strict=True)
    }
    sunk = float(data.xpos[feet, 2].mean() - low)
    height = float(data.qpos[int(model.jnt_qposadr[model.body_jntadr[trunk]]) + 2]) - sunk
    return posture | {f"{model.body(trunk).name}.position.z": round(height, 5)}


def _legs(model: Any, feet: list[int], trunk: int) -> list[int]:
    """Return the hinges between the trunk and the feet, by MuJoCo's numbers."""
    results: list[int] = []
    for foot in feet:
        link = foot
        while link not in (0, trunk):
            first = int(model.body_jntadr[link])
            results += range(first, first + int(model.body_jntnum[link]))
            link = int(model.body_parentid[link])
    return results


def _along(model: Any, data: Any, joint: int, bends: dict[str, float]) -> bool:
    axes = [data.xaxis[model.joint(name).id] for name in bends]
    return any(abs(float(axis @ data.xaxis[joint])) > 0.99 for axis in axes)


def _middle(model: Any, data: Any, foot: int) -> Array:
    """Return the middle of what a foot stands on: its lowest shape that touches."""
    shapes = [g for g in range(model.ngeom) if model.geom_bodyid[g] == foot]
    solid = [g for g in shapes if model.geom_contype[g] or model.geom_conaffinity[g]] or shapes
    return np.asarray(data.geom_xpos[min(solid, key=lambda g: data.geom_xpos[g][2])])
