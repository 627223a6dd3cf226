"""From where the runs of a task begin."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import TaskError
from morph.sim.start import started
from morph.task.push import Push


@dataclass(frozen=True, kw_only=True)
class Start:
    """A state, and how far runs begin from it."""

    position: Mapping[str, float] = field(default_factory=dict)
    """Position of joints by name, as `Simulator.run(start=...)` takes it."""
    speed: Mapping[str, float] = field(default_factory=dict)
    """Velocity of joints by name, as `Simulator.run(speed=...)` takes it."""
    spread: float = 0.01
    """Standard deviation of every position, m or rad, and every velocity, per s."""
    moving: tuple[str, ...] | None = None
    """The joints that are spread; None for all of them."""
    push: Push | None = None
    """By which runs begin, beside their speed."""

    def __post_init__(self) -> None:
        """Check the spread."""
        if not (math.isfinite(self.spread) and self.spread >= 0.0):
            raise TaskError(
                f"its spread is {self.spread:g}", where="a start", fix="give 0 or more, in rad or m"
            )

    def sample(
        self, robot: Robot, model: Any, rows: int, rng: np.random.Generator | None
    ) -> tuple[Array, Array]:
        """Return where runs begin: positions (rows, nq) and velocities (rows, nv).

        Without `rng` all begin in the middle.

        Raises:
            RobotError: A name is not the robot's.
        """
        if rng is not None:
            return self.spread_by(robot, model, rng.standard_normal((2, rows, model.nv)))
        q, v = self._middle(robot, model)
        return np.tile(q, (rows, 1)), np.tile(v, (rows, 1))

    def spread_by(self, robot: Robot, model: Any, chance: Array) -> tuple[Array, Array]:
        """Return where runs begin whose chance was drawn already.

        Args:
            robot: The body.
            model: Its compiled `mujoco.MjModel`.
            chance: Standard normal numbers of all positions, then of all velocities,
                shape (2, rows, nv).

        Raises:
            RobotError: A name is not the robot's.
        """
        q, v = self._middle(robot, model)
        # A closed chain cannot be spread joint by joint: it would be torn.
        shift, more = self.spread * self._moves(model) * chance
        position = np.tile(q, (len(shift), 1))
        if model.nq == model.nv:
            return position + shift, v + more
        for row, each in enumerate(shift):
            mujoco.mj_integratePos(model, position[row], each, 1.0)
        return position, v + more

    def _middle(self, robot: Robot, model: Any) -> tuple[Array, Array]:
        q, v = started(robot, model, self.position, self.speed)
        return q, v if self.push is None else v + self.push.velocity(model, q)

    def _moves(self, model: Any) -> Array:
        if self.moving is None:
            return np.ones(model.nv)
        moves = np.zeros(model.nv)
        for name in self.moving:
            joint = model.joint(name)
            moves[joint.dofadr[0] : joint.dofadr[0] + {0: 6, 1: 3}.get(int(joint.type[0]), 1)] = 1.0
        return moves
