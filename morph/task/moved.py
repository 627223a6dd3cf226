"""What a body did, as the terms of a task see it: many runs at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

import mujoco
import numpy as np

from morph.arrays import Array, Mask
from morph.body.robot import Robot

FREE: Final = mujoco.mjtJoint.mjJNT_FREE.value
BALL: Final = mujoco.mjtJoint.mjJNT_BALL.value
SLIDE: Final = mujoco.mjtJoint.mjJNT_SLIDE.value


@dataclass(frozen=True, kw_only=True)
class LinkPose:
    """Where a link is in the world."""

    position: Array
    """Its origin, m, shape (..., 3)."""
    rotation: Array
    """Its axes, as columns, shape (..., 3, 3)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Moved:
    """States and commands of many runs at the control times."""

    robot: Robot
    """The body."""
    model: Any
    """Its compiled `mujoco.MjModel`."""
    time: Array
    """The control times, s, shape (samples,)."""
    position: Array
    """MuJoCo's `qpos`, shape (..., samples, nq)."""
    velocity: Array
    """MuJoCo's `qvel`, shape (..., samples, nv)."""
    command: Array
    """What is commanded from each time on, shape (..., samples, nu); the last is held."""
    stable: Mask | None = None
    """Which runs stayed stable, shape (...,); None if all did."""

    def joint(self, name: str) -> Array:
        """Return the position of a hinge, rad, or a slide, m, shape (..., samples)."""
        return np.asarray(self.position[..., self.model.joint(name).qposadr[0]])

    def speed(self, name: str) -> Array:
        """Return the velocity of a hinge or a slide, per s, shape (..., samples)."""
        return np.asarray(self.velocity[..., self.model.joint(name).dofadr[0]])

    def pose(self, body: int) -> LinkPose:
        """Return where a link is at every time; nowhere (nan) where a position is no number.

        The kinematics of its own chain, as `mj_kinematics` has them, for all times at once: MuJoCo
        would place every link of the body one time after another.

        Args:
            body: MuJoCo's number of the link's body.
        """
        if body not in self._poses:
            self._poses[body] = self._placed(body)
        return self._poses[body]

    @cached_property
    def _poses(self) -> dict[int, LinkPose]:
        """Poses by body, of those that were asked for; at first that of the world."""
        shape = self.position.shape[:-1]
        lost = np.where(np.isfinite(self.position).all(axis=-1), 0.0, np.nan)
        world = np.broadcast_to(np.eye(3), (*shape, 3, 3)) + lost[..., None, None]
        return {0: LinkPose(position=np.zeros((*shape, 3)) + lost[..., None], rotation=world)}

    def _placed(self, body: int) -> LinkPose:
        model, joint = self.model, int(self.model.body_jntadr[body])
        above = self.pose(int(model.body_parentid[body]))
        if joint >= 0 and model.jnt_type[joint] == FREE:
            at = int(model.jnt_qposadr[joint])
            return LinkPose(
                position=self.position[..., at : at + 3] + 0.0 * above.position,
                rotation=_rotation(self.position[..., at + 3 : at + 7]) + 0.0 * above.rotation,
            )
        position = above.position + above.rotation @ model.body_pos[body]
        rotation = above.rotation @ _rotation(model.body_quat[body])
        for each in range(joint, joint + int(model.body_jntnum[body])):
            at, axis, arm = int(model.jnt_qposadr[each]), model.jnt_axis[each], model.jnt_pos[each]
            value = self.position[..., at] - model.qpos0[at]
            if model.jnt_type[each] == SLIDE:
                position = position + (rotation @ axis) * value[..., None]
                continue
            anchor = position + rotation @ arm
            turn = (
                _rotation(self.position[..., at : at + 4])
                if model.jnt_type[each] == BALL
                else _turn(axis, value)
            )
            rotation = rotation @ turn
            position = anchor - rotation @ arm
        return LinkPose(position=position, rotation=rotation)


def _rotation(quaternion: Array) -> Array:
    """Return the rotation matrices of quaternions (..., 4), the scalar first, shape (..., 3, 3)."""
    w, x, y, z = np.moveaxis(quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True), -1, 0)
    rows = (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)),
        (2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)),
        (2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _turn(axis: Array, angle: Array) -> Array:
    """Return rotations by angles (...) about an axis, shape (..., 3, 3): Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, versine = np.sin(angle)[..., None, None], (1.0 - np.cos(angle))[..., None, None]
    return np.asarray(np.eye(3) + sine * cross + versine * (cross @ cross))
