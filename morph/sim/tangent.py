"""Small moves of a state: where a body is once moved, and how far apart two states are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array, Integers, Mask

# To compare with a member of the enumeration takes as long as all else of a move.
FREE, BALL, HINGE, SLIDE = (
    int(kind)
    for kind in (
        mujoco.mjtJoint.mjJNT_FREE,
        mujoco.mjtJoint.mjJNT_BALL,
        mujoco.mjtJoint.mjJNT_HINGE,
        mujoco.mjtJoint.mjJNT_SLIDE,
    )
)

SMALL = 1e-9
"""Angle below which a rotation is told by its axis times its angle, rad."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Coordinates:
    """Where joints stand in `qpos` and in `qvel`."""

    positions: int
    """Length of `qpos`."""
    dofs: int
    """Length of `qvel`."""
    straight: Integers
    """Index in `qpos` of each coordinate that is a number: of hinges, slides and free joints."""
    dof: Integers
    """Index in `qvel` of each of these."""
    balls: tuple[tuple[int, int], ...]
    """Where a quaternion begins in `qpos`, and its rotation in `qvel`."""

    @classmethod
    def of(cls, kinds: Sequence[int]) -> Coordinates:
        """Return the coordinates of joints of some of MuJoCo's kinds, in their order."""
        straight: list[int] = []
        dof: list[int] = []
        balls: list[tuple[int, int]] = []
        at = turn = 0
        for kind in kinds:
            count = 3 if kind == FREE else 0 if kind == BALL else 1
            straight += range(at, at + count)
            dof += range(turn, turn + count)
            at, turn = at + count, turn + count
            if kind in (FREE, BALL):
                balls.append((at, turn))
                at, turn = at + 4, turn + 3
        return cls(
            positions=at,
            dofs=turn,
            straight=np.array(straight, dtype=int),
            dof=np.array(dof, dtype=int),
            balls=tuple(balls),
        )

    def moved_by(self, position: Array, step: Array) -> Array:
        """Return positions after a small move, as `mj_integratePos` does for one; shape (..., nq).

        Args:
            position: MuJoCo's `qpos`, shape (..., nq).
            step: The move in the coordinates of `qvel`, shape (..., nv).
        """
        if not self.balls:
            return np.asarray(position + step)
        shape = np.broadcast_shapes(position.shape[:-1], step.shape[:-1])
        moved = np.broadcast_to(position, (*shape, self.positions)).copy()
        moved[..., self.straight] += step[..., self.dof]
        for at, turn in self.balls:
            quaternion, by = moved[..., at : at + 4], step[..., turn : turn + 3]
            moved[..., at : at + 4] = product(quaternion, turned(by))
        return moved

    def apart(self, position: Array, origin: Array) -> Array:
        """Return the move that leads from an origin to a position, shape (..., nv).

        It is `mj_differentiatePos` for many: what `moved_by` undoes.

        Args:
            position: MuJoCo's `qpos`, shape (..., nq).
            origin: Likewise.
        """
        if not self.balls:
            return np.asarray(position - origin)
        shape = np.broadcast_shapes(position.shape[:-1], origin.shape[:-1])
        move = np.empty((*shape, self.dofs))
        move[..., self.dof] = position[..., self.straight] - origin[..., self.straight]
        for at, turn in self.balls:
            back = conjugate(origin[..., at : at + 4])
            move[..., turn : turn + 3] = rotation(product(back, position[..., at : at + 4]))
        return move


def moved_by(model: Any, position: Array, step: Array) -> Array:
    """Return positions of a compiled `mujoco.MjModel` after a small move; see `Coordinates`."""
    return Coordinates.of(model.jnt_type.tolist()).moved_by(position, step)


def apart(model: Any, position: Array, origin: Array, *, wrapped: bool = False) -> Array:
    """Return the move that leads from an origin to a position; see `Coordinates`.

    Args:
        model: The compiled `mujoco.MjModel`.
        position: MuJoCo's `qpos`, shape (..., nq).
        origin: Likewise.
        wrapped: Whether a hinge without limits is taken the shorter way round.
    """
    move = Coordinates.of(model.jnt_type.tolist()).apart(position, origin)
    if wrapped:
        round_about = turning(model)
        angle = move[..., round_about]
        move[..., round_about] = angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))
    return move


def turning(model: Any) -> Mask:
    """Return which degrees of freedom are hinges without limits, shape (nv,)."""
    result = np.zeros(model.nv, dtype=bool)
    free = (model.jnt_type == HINGE) & (model.jnt_limited == 0)
    result[model.jnt_dofadr[free]] = True
    return result


def product(left: Array, right: Array) -> Array:
    """Return the product of two quaternions, w first, shape (..., 4)."""
    a, x = left[..., :1], left[..., 1:]
    b, y = right[..., :1], right[..., 1:]
    real = a * b - np.sum(x * y, axis=-1, keepdims=True)
    return np.concatenate([real, a * y + b * x + np.cross(x, y)], axis=-1)


def conjugate(quaternion: Array) -> Array:
    """Return the quaternion of the inverse rotation, w first, shape (..., 4)."""
    return np.asarray(quaternion * np.array([1.0, -1.0, -1.0, -1.0]))


def turned(turn: Array) -> Array:
    """Return the quaternion of a rotation vector, rad, shape (..., 4)."""
    angle = np.linalg.norm(turn, axis=-1, keepdims=True)
    # sin(a / 2) / a, which np.sinc gives at zero too.
    return np.concatenate(
        [np.cos(angle / 2.0), 0.5 * np.sinc(angle / (2.0 * np.pi)) * turn], axis=-1
    )


def rotation(quaternion: Array) -> Array:
    """Return the rotation vector of a quaternion, of at most pi, rad, shape (..., 3)."""
    axis = quaternion[..., 1:]
    sine = np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, quaternion[..., :1])
    angle = np.where(angle > np.pi, angle - 2.0 * np.pi, angle)
    return np.where(sine > SMALL, angle / np.maximum(sine, SMALL), 2.0) * axis
