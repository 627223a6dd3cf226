"""The figures of a body under design: mass, size, reach, and what its motors have left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.design.reach import Reach
from morph.arrays import Array
from morph.body.holding import Holding, HoldingMotor, least
from morph.body.poses import drawn
from morph.body.posture import Posture
from morph.body.robot import Robot


@dataclass(frozen=True, kw_only=True, eq=False)
class Measures:
    """Figures of a body over the poses that it can take."""

    mass: float
    """Of all links, kg."""
    size: tuple[float, float, float]
    """Of the upright box around it at rest, m."""
    reach: float
    """The farthest that any point gets from its base, m."""
    joints: int
    """Joints that move by themselves."""
    freedoms: int
    """Degrees of freedom, loops closed."""
    motors: tuple[HoldingMotor, ...]
    """Every motor of a hinge or slide."""
    limits: Array
    """Their limits, N m or N, NaN where none is known, shape (motors,)."""
    efforts: Array
    """The greatest effort that each holds in any pose, shape (motors,)."""
    poses: int
    """How many poses that is."""

    @property
    def margin(self) -> float | None:
        """The least share of a limit that is left in any pose; None without limits."""
        return least(self.efforts, self.limits)[0]


def measured(robot: Robot, posture: Posture, shapes: Sequence[PictureShape]) -> Measures:
    """Return the figures of a robot."""
    poses = drawn(posture)
    holding, reach = Holding(robot, posture), Reach(posture, shapes)
    efforts = np.array([np.abs(holding.at(pose)) for pose in poses])
    return Measures(
        mass=robot.mass,
        size=_size(posture, shapes),
        reach=reach.most(poses),
        joints=len(posture.handles),
        freedoms=int(posture.model.nv) - len(posture.tied),
        motors=holding.motors,
        limits=holding.limits,
        efforts=efforts.max(axis=0) if len(holding.motors) else np.zeros(0),
        poses=len(poses),
    )


def _size(posture: Posture, shapes: Sequence[PictureShape]) -> tuple[float, float, float]:
    data = posture.data
    data.qpos[:] = posture.rest
    mujoco.mj_kinematics(posture.model, data)
    corners = [
        data.xpos[shape.body] + shape.vertices @ data.xmat[shape.body].reshape(3, 3).T
        for shape in shapes
        if shape.body > 0
    ]
    if not corners:
        return 0.0, 0.0, 0.0
    points = np.concatenate(corners)
    x, y, z = (points.max(axis=0) - points.min(axis=0)).tolist()
    return x, y, z
