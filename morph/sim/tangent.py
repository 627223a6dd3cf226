"""Small moves of a state: where a body is once moved, and how far apart two states are."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array, Mask

# To compare with a member of the enumeration takes as long as all else of a move.
FREE, BALL, HINGE = (
    int(kind)
    for kind in (
        mujoco.mjtJoint.mjJNT_FREE,
        mujoco.mjtJoint.mjJNT_BALL,
        mujoco.mjtJoint.mjJNT_HINGE,
    )
)

SMALL = 1e-9
"""Angle below which a rotation is told by its axis times its angle, rad."""


def moved_by(model: Any, position: Array, step: Array) -> Array:
    """Return positions after a small move, as `mj_integratePos` does for one; shape (..., nq).

    Args:
        model: The compiled `mujoco.MjModel`.
        position: MuJoCo's `qpos`, shape (..., nq).
        step: The move in the coordinates of `qvel`, shape (..., nv).
    """
    shape = np.broadcast_shapes(position.shape[:-1], step.shape[:-1])
    moved = np.broadcast_to(position, (*shape, model.nq)).copy()
    straight, dof, balls = _addresses(model)
    moved[..., straight] += step[..., dof]
    for at, turn in balls:
        moved[..., at : at + 4] = _times(
            moved[..., at : at + 4], _turned(step[..., turn : turn + 3])
        )
    return moved


def apart(model: Any, position: Array, origin: Array, *, wrapped: bool = False) -> Array:
    """Return the move that leads from an origin to a position, shape (..., nv).

    It is `mj_differentiatePos` for many: what `moved_by` undoes.

    Args:
        model: The compiled `mujoco.MjModel`.
        position: MuJoCo's `qpos`, shape (..., nq).
        origin: Likewise.
        wrapped: Whether a hinge without limits is taken the shorter way round.
    """
    shape = np.broadcast_shapes(position.shape[:-1], origin.shape[:-1])
    move = np.empty((*shape, model.nv))
    straight, dof, balls = _addresses(model)
    move[..., dof] = position[..., straight] - origin[..., straight]
    if wrapped:
        round_about = turning(model)
        angle = move[..., round_about]
        move[..., round_about] = angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
    for at, turn in balls:
        back = origin[..., at : at + 4] * np.array([1.0, -1.0, -1.0, -1.0])
        between = _times(back, position[..., at : at + 4])
        move[..., turn : turn + 3] = _turn(between)
    return move


def turning(model: Any) -> Mask:
    """Return which degrees of freedom are hinges without limits, shape (nv,)."""
    found = np.zeros(model.nv, dtype=bool)
    free = (model.jnt_type == HINGE) & (model.jnt_limited == 0)
    found[model.jnt_dofadr[free]] = True
    return found


def _addresses(model: Any) -> tuple[Any, Any, list[tuple[int, int]]]:
    """Return what moves straight in `qpos`, in `qvel`, and where both hold rotations."""
    straight: list[int] = []
    dof: list[int] = []
    balls: list[tuple[int, int]] = []
    kinds, places = model.jnt_type.tolist(), model.jnt_qposadr.tolist()
    for kind, at, turn in zip(kinds, places, model.jnt_dofadr.tolist(), strict=True):
        if kind == FREE:
            straight += range(at, at + 3)
            dof += range(turn, turn + 3)
            balls.append((at + 3, turn + 3))
        elif kind == BALL:
            balls.append((at, turn))
        else:
            straight.append(at)
            dof.append(turn)
    return np.array(straight, dtype=int), np.array(dof, dtype=int), balls


def _times(left: Array, right: Array) -> Array:
    """Return the product of two quaternions, w first, shape (..., 4)."""
    a, x = left[..., :1], left[..., 1:]
    b, y = right[..., :1], right[..., 1:]
    real = a * b - np.sum(x * y, axis=-1, keepdims=True)
    return np.concatenate([real, a * y + b * x + np.cross(x, y)], axis=-1)


def _turned(turn: Array) -> Array:
    """Return the quaternion of a rotation vector, rad, shape (..., 4)."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    # sin(a / 2) / a, which np.sinc gives at zero too.
    return np.concatenate(
        [np.cos(angle / 2.0), 0.5 * np.sinc(angle / (2.0 * np.pi)) * turn], axis=-1
    )


def _turn(quaternion: Array) -> Array:
    """Return the rotation vector of a quaternion, of at most pi, rad, shape (..., 3)."""
    axis = quaternion[..., 1:]
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, quaternion[..., :1])
    angle = np.where(angle > np.pi, angle - 2.0 * np.pi, angle)
    return np.where(sine > SMALL, angle / np.maximum(sine, SMALL), 2.0) * axis
