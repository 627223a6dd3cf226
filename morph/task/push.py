"""A push: an impulse on a body at rest, by which a run begins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.errors import TaskError


@dataclass(frozen=True, kw_only=True)
class Push:
    """An impulse p on a point of a link: right after it the velocity is more by M^-1 J' p.

    What stands on a floor is taken to be held by nothing meanwhile: contacts answer afterwards.

    Source: Featherstone 2008, Rigid Body Dynamics Algorithms, section 11.7 (impulses).
    """

    link: str
    """What is pushed."""
    impulse: tuple[float, float, float]
    """p, in the world, N s."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The point in the link's frame, m."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not all(math.isfinite(each) for each in (*self.impulse, *self.offset)):
            raise TaskError(
                "its impulse or its place is no finite number",
                where=f"a push on {self.link}",
                fix="give finite numbers, N s and m",
            )

    def velocity(self, model: Any, position: Array) -> Array:
        """Return what the velocities are more by right after it, shape (nv,).

        Args:
            model: The compiled `mujoco.MjModel`.
            position: Where the body is, MuJoCo's `qpos`, shape (nq,).
        """
        data = mujoco.MjData(model)
        data.qpos = position
        mujoco.mj_fwdPosition(model, data)
        body = model.body(self.link).id
        where = data.xpos[body] + data.xmat[body].reshape(3, 3) @ np.array(self.offset)
        jacobian = np.zeros((3, model.nv))
        mujoco.mj_jac(model, data, jacobian, None, where, body)
        after = np.zeros((1, model.nv))
        mujoco.mj_solveM(model, data, after, (jacobian.T @ np.array(self.impulse))[None])
        return np.asarray(after[0])
