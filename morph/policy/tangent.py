"""From what is seen to how far a state is from another: what turns the gain of an LQR around."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.policy.observing import addresses, unit_of
from morph.policy.policy import Observation


def tangent(
    robot: Robot, model: Any, position: Array, observation: tuple[Observation, ...]
) -> Array:
    """Return T, so that a state near another is T (o - o0) from it, shape (2 nv, observations).

    That difference is MuJoCo's (`mj_differentiatePos`, then the velocities): a quaternion's
    four numbers make three. A law u = -K dx about a state is u = -K T (o - o0) of what is seen,
    which a `Linear` and a `Track` can hold. To first order; the quaternion must be seen with
    the sign that it has in `position`. Older samples count for nothing.

    Source: for q near p, log(p* q) is 2 vec(p* q) to first order; Sola 2017, Quaternion
    kinematics for the error-state Kalman filter, eqs 101 and 193.

    Args:
        robot: The body.
        model: Its compiled `mujoco.MjModel`.
        position: The other state's `qpos`, shape (nq,).
        observation: What is seen.

    Raises:
        PolicyError: The body lacks a channel, or a part of the state is not seen.
    """
    state = _state(model, position)
    where = addresses(robot, model)
    result = np.zeros((2 * model.nv, sum(each.history for each in observation)))
    at = 0
    for each in observation:
        unit_of(robot, each.channel)
        result[:, at] = each.scale * state[:, where[each.channel]]
        at += each.history
    unseen = sorted(where.keys() - {each.channel for each in observation})
    if unseen:
        raise PolicyError(
            f"it does not see {', '.join(unseen)}",
            where=f"a law about a state of {robot.name}",
            fix="observe the whole state, observations_of(robot)",
        )
    return result


def _state(model: Any, position: Array) -> Array:
    """Return d(difference) / d(qpos, qvel) at a position, shape (2 nv, nq + nv)."""
    result = np.zeros((2 * model.nv, model.nq + model.nv))
    result[model.nv :, model.nq :] = np.eye(model.nv)
    for joint in range(model.njnt):
        q, v, kind = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint]), model.jnt_type
        free = kind[joint] == mujoco.mjtJoint.mjJNT_FREE
        if free or kind[joint] == mujoco.mjtJoint.mjJNT_BALL:
            if free:
                result[v : v + 3, q : q + 3] = np.eye(3)
                q, v = q + 3, v + 3
            w, x, y, z = position[q : q + 4]
            result[v : v + 3, q : q + 4] = 2.0 * np.array(
                [[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]]
            )
        else:
            result[v, q] = 1.0
    return result
