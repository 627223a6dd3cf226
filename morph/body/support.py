"""What motors must give to hold a robot up that stands on its soles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.soles import Sole

FRICTION = 0.6
"""Coefficient of friction that feet may use to stand."""
MOST = 1e4
"""What a motor without a known limit counts as able to give, N m or N."""
LITTLE = 1e-3
"""Weight of all efforts together against the largest: of two ways the one with less effort."""


def holding_efforts(
    robot: Robot, model: Any, data: Any, link: str, soles: Sequence[Sole]
) -> dict[str, float] | None:
    """Return by actuator the effort, N m or N at its joint, that holds a pose on soles at rest.

    Forces f at the soles within pyramids of friction and efforts u of the motors balance gravity
    and springs, J^T f + u = g; of all such the largest |u| / limit is least, by a linear
    programme. Joints without a motor count as locked.

    Args:
        robot: The robot.
        model: Its `mujoco.MjModel`.
        data: A `MjData` at the pose.
        link: The link that moves freely.
        soles: What touches the floor.

    Returns:
        The efforts, also beyond limits; None where no forces at these soles hold the base.
    """
    from scipy.optimize import linprog

    data.qvel[:] = 0.0
    for stage in (mujoco.mj_kinematics, mujoco.mj_comPos, mujoco.mj_tendon):
        stage(model, data)
    mujoco.mj_comVel(model, data)
    mujoco.mj_passive(model, data)
    needed: Array = np.zeros(model.nv)
    mujoco.mj_rne(model, data, 0, needed)
    needed -= data.qfrc_passive
    lift = np.concatenate([_forces(model, data, sole) for sole in soles]).T
    motors = [
        (each.name, int(model.joint(each.joint).dofadr[0]), each.limit or MOST)
        for each in robot.actuators
        if each.joint
    ]
    base = model.body(link).id
    first = int(model.body_dofadr[base])
    loose = range(first, first + int(model.body_dofnum[base]))
    forces, count = lift.shape[1], len(motors)
    # Unknown: forces along the edges of the pyramids, efforts as shares of the limits one way and
    # the other, and the largest share.
    rows, right = [], []
    for dof in dict.fromkeys([*loose, *(dof for _, dof, _ in motors)]):
        shares = [limit * (each == dof) for _, each, limit in motors]
        rows.append(np.concatenate([lift[dof], shares, np.negative(shares), [0.0]]))
        right.append(float(needed[dof]))
    least = np.hstack([np.zeros((2 * count, forces)), np.eye(2 * count), -np.ones((2 * count, 1))])
    weight = max(float(model.body_mass.sum() * np.abs(model.opt.gravity).max()), 1e-9)
    result = linprog(
        np.concatenate([np.full(forces, 1e-6 / weight), np.full(2 * count, LITTLE), [1.0]]),
        A_ub=least if count else None,
        b_ub=np.zeros(2 * count) if count else None,
        A_eq=np.array(rows),
        b_eq=np.array(right),
        bounds=(0.0, None),
    )
    if result.x is None:
        return None
    shares = result.x[forces : forces + count] - result.x[forces + count : -1]
    return {
        name: float(share) * limit
        for (name, _, limit), share in zip(motors, shares.tolist(), strict=True)
    }


def beyond_limits(robot: Robot, effort: Mapping[str, float]) -> dict[str, float]:
    """Return those of some efforts that are beyond what their actuators give."""
    limits = {each.name: each.limit or math.inf for each in robot.actuators}
    return {name: each for name, each in effort.items() if abs(each) > limits[name] * (1.0 + 1e-6)}


def _forces(model: Any, data: Any, sole: Sole) -> Array:
    """Return what 1 N along the edges of a sole's pyramids of friction does, (edges, nv)."""
    edges = []
    for point in sole.corners(data):
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, jacobian, None, point, sole.body)
        for x, y in ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)):
            edges.append(np.array([FRICTION * x, FRICTION * y, 1.0]) @ jacobian)
    return np.array(edges)
