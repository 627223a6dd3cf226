"""Plant whose state includes the commands that are still in the delay line."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import lsq_linear

from morph.arrays import Array
from morph.physics.effect import Effect
from morph.search.trajectory.cost import Quadratic, TaskCost
from morph.search.trajectory.ddp import Trajectories
from morph.search.trajectory.plant import Plant
from morph.search.trajectory.tangent import moved_by
from morph.sim.drive import received
from morph.sim.simulator import Simulator

STEP = 1e-6
"""Half the distance of a difference, in the state's units and in the command's."""

FORGOTTEN = 0.02
"""Share of a command that may still be under way when it is left out of the state."""


def prompt(simulator: Simulator) -> Simulator:
    """Return a simulator without what changes commands on their way."""
    kept = tuple(each for each in simulator.effects if not _late(each))
    if len(kept) == len(simulator.effects):
        return simulator
    return Simulator(simulator.robot, kept, step=simulator.step, integrator=simulator.integrator)


def is_late(simulator: Simulator) -> bool:
    """Return whether anything changes commands on their way."""
    return any(_late(each) for each in simulator.effects)


def _late(effect: Effect) -> bool:
    return type(effect).command is not Effect.command


class DelayAugmentedPlant:
    """A body behind the line on which its commands travel.

    Its state is z = (x, du of the last period, du of the one before, ...), as many as matter.

    Args:
        simulator: The body under its effects, those on commands among them; these are linear.
        period: How long a command is held, s.
        periods: How many a run has.
    """

    def __init__(self, simulator: Simulator, period: float, periods: int) -> None:
        """Find what each command does in its own period and in those that follow."""
        self._effects, self._robot = simulator.effects, simulator.robot
        self.plant = Plant(prompt(simulator), simulator.step)
        self.model: Any = self.plant.model
        self.low, self.high = self.plant.low, self.plant.high
        self.step, self.substeps = simulator.step, round(period / simulator.step)
        self.periods = periods
        m = self.model.nu
        # One unit of one command at one time: what arrives, (periods, m, periods, substeps).
        unit = np.zeros((periods * m, periods, m))
        for at in range(periods):
            for which in range(m):
                unit[at * m + which, at, which] = 1.0
        arrived = self.arriving(unit).reshape(periods, m, periods, self.substeps, m)
        first = periods // 3
        share = np.abs(arrived[first]).max((0, 2, 3))[first:]
        matter = np.flatnonzero(share > FORGOTTEN)
        self.memory = max(1, int(matter.max(initial=0)))
        # By age: (periods, memory + 1, m, substeps, m), of the command so many periods before.
        self._arrived = arrived
        self.shape = np.zeros((periods, self.memory + 1, m, self.substeps, m))
        for at in range(periods):
            for age in range(min(at, self.memory) + 1):
                self.shape[at, age] = arrived[at - age, :, at]

    def arriving(self, command: Array) -> Array:
        """Return what arrives of commands (rows, periods, m), (rows, periods, substeps, m)."""
        rows, periods, m = command.shape
        given = np.empty((rows, periods * self.substeps, m))
        for actuator in self._robot.actuators:
            index = self.model.actuator(actuator.name).id
            steps = np.repeat(command[..., index], self.substeps, axis=1)
            given[..., index] = received(self._effects, actuator.name, steps, self.step)
        return given.reshape(rows, periods, self.substeps, m)

    def told(self, wanted: Array, low: Array, high: Array) -> Array:
        """Return commands within bounds of which what arrives is nearest to what is wanted.

        Args:
            wanted: Shape (rows, periods, m), as if commands were prompt.
            low: Least commands, shape (m,).
            high: Greatest commands.
        """
        rows, periods, m = wanted.shape
        matrix = self._arrived.reshape(periods * m, -1).T
        goal = np.repeat(wanted[:, :, None], self.substeps, axis=2).reshape(rows, -1)
        bounds = np.tile(low, periods), np.tile(high, periods)
        results = [lsq_linear(matrix, each, bounds=bounds).x for each in goal]
        return np.stack(results).reshape(rows, periods, m)

    def through(self, q: Array, v: Array, given: Array) -> tuple[Array, Array]:
        """Return states one period later under what arrives, given (rows, substeps, m)."""
        for at in range(self.substeps):
            q, v = self.plant.advance(q, v, given[:, at])
        return q, v

    def linearised(self, q: Array, v: Array, given: Array) -> tuple[Array, Array, Array]:
        """Return A and B of dz' = A dz + B du along runs, and what a force would do at once.

        Args:
            q: Shape (rows, periods, nq).
            v: Shape (rows, periods, nv).
            given: What arrives, shape (rows, periods, substeps, m).

        Returns:
            A (rows, periods, size, size), B (rows, periods, size, m), and a prompt command's
            effect, of B's shape.
        """
        nv, m = self.model.nv, self.model.nu
        n, rows, periods = 2 * nv, *q.shape[:2]
        late = m * (self.memory + 1)
        given = np.clip(given, self.low + STEP, self.high - STEP)
        move = np.zeros((n + late + m, n))
        move[:n] = np.eye(n)
        pushed = np.zeros((periods, n + late + m, self.substeps, m))
        pushed[:, n : n + late] = self.shape[:periods].reshape(periods, late, self.substeps, m)
        pushed[:, n + late :] = np.eye(m)[:, None, :]
        many = (rows, periods, n + late + m)
        ends = []
        for sign in (STEP, -STEP):
            place = moved_by(self.model, q[:, :, None], sign * move[:, :nv])
            speed = np.broadcast_to(v[:, :, None] + sign * move[:, nv:], (*many, nv))
            force = given[:, :, None] + sign * pushed
            ends.append(
                self.through(
                    np.broadcast_to(place, (*many, self.model.nq)).reshape(-1, self.model.nq),
                    speed.reshape(-1, nv),
                    force.reshape(-1, self.substeps, m),
                )
            )
        slope = self.plant.off(*ends[0], *ends[1]).reshape(*many, n) / (2.0 * STEP)
        slope = np.swapaxes(slope, -1, -2)
        size = n + m * self.memory
        A, B = np.zeros((rows, periods, size, size)), np.zeros((rows, periods, size, m))
        push = np.zeros_like(B)
        A[..., :n, :n], B[..., :n, :] = slope[..., :n], slope[..., n : n + m]
        A[..., :n, n:] = slope[..., n + m : n + late]
        push[..., :n, :] = slope[..., n + late :]
        # A command of this period is one of the last period in the next, and so on.
        B[..., n : n + m, :] = np.eye(m)
        A[..., n + m :, n : size - m] = np.eye(size - n - m)
        return A, B, push

    def widened(self, cost: Quadratic) -> Quadratic:
        """Return a cost of the state as one of the state and the commands under way."""
        more = self.model.nu * self.memory
        wide = ((0, 0), (0, 0))
        return Quadratic(
            x=np.pad(cost.x, (*wide, (0, more))),
            u=cost.u,
            xx=np.pad(cost.xx, (*wide, (0, more), (0, more))),
            uu=cost.uu,
            ux=np.pad(cost.ux, (*wide, (0, 0), (0, more))),
        )

    def followed(
        self,
        cost: TaskCost,
        plan: Trajectories,
        gain: Array,
        change: Array,
        low: Array,
        high: Array,
    ) -> Trajectories:
        """Return runs under u = clip(command + change + gain dz), with their costs.

        Args:
            cost: What runs cost.
            plan: From what dz is counted.
            gain: Shape (rows, periods, m, size).
            change: Shape (rows, periods, m).
            low: Least commands, shape (m,).
            high: Greatest commands.
        """
        q, v, u = plan.position.copy(), plan.velocity.copy(), plan.command.copy()
        rows, periods, m = u.shape
        past = np.zeros((rows, self.memory, m))
        for at in range(periods):
            dx = self.plant.off(q[:, at], v[:, at], plan.position[:, at], plan.velocity[:, at])
            dz = np.concatenate([dx, past.reshape(rows, -1)], axis=1)
            back = (gain[:, at] @ dz[..., None])[..., 0]
            wanted = plan.command[:, at] + change[:, at] + back
            u[:, at] = np.clip(np.where(np.isfinite(wanted), wanted, 0.0), low, high)
            past[:, 1:] = past[:, :-1].copy()
            past[:, 0] = u[:, at] - plan.command[:, at]
            given = self.arriving(u[:, : at + 1])[:, -1]
            q[:, at + 1], v[:, at + 1] = self.through(q[:, at], v[:, at], given)
        return Trajectories(position=q, velocity=v, command=u, cost=cost.values(q, v, u).sum(-1))
