"""A batch of simulations of which some may be started anew while the others go on."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError

from morph.arrays import Array, Integers, Mask
from morph.errors import SimulationFailed
from morph.physics.effect import Effect
from morph.physics.fluid.settle import batches
from morph.physics.stacked import stacked
from morph.sim.drive import received
from morph.sim.rollout import quiet
from morph.sim.rows import Rows
from morph.sim.threads import batch_threads
from morph.task.task import Task


class BatchPlant:
    """Simulations of a task's body, each at its own time.

    Args:
        task: Whose body, world, step and period are simulated.
        rows: How many simulations.
        effects: What acts on the body beyond what the task says.

    Raises:
        SimulationFailed: The body or its effects cannot run so.
    """

    def __init__(self, task: Task, rows: int, effects: tuple[Effect, ...] = ()) -> None:
        """Compile the body, and start nothing yet."""
        self._simulator = task.simulator(effects)
        self.model: Any = self._simulator.model
        if not batches(self.model):
            raise SimulationFailed(
                "an environment needs the compiled fluid",
                where=f"robot {task.robot.name} in a fluid, which runs in numpy here",
                fix="install a C compiler, or `pip install ziglang`, which brings one",
            )
        self._batch = Batch(self.model, rows, batch_threads(rows))
        self._batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self.position, self.velocity = self._batch.bind("qpos"), self._batch.bind("qvel")
        self._control = self._batch.bind("ctrl")
        self._each = round(task.period / task.step)
        effects = self._simulator.effects
        self._filtered = any(type(each).command is not Effect.command for each in effects)
        steps = self._each * (task.samples - 1) if self._filtered else 0
        self._told = np.zeros((rows, self.model.nu, steps))
        self._seen = Rows(self._batch, task.step)
        self._acting = [stacked([each] * rows) for each in effects if each.stepped]
        for each in self._acting:
            # What an effect remembers could not be forgotten for some rows alone.
            if each.initial_state(self._seen) is not None:
                raise SimulationFailed(
                    f"{each.label} remembers the past, which an environment cannot start anew",
                    where=f"robot {task.robot.name}",
                    fix="leave it out",
                )

    @property
    def unstable(self) -> Mask:
        """Which simulations became unstable since they were started, shape (rows,)."""
        return np.asarray(self._batch.warning[..., 1].any(axis=1))

    def start(self, rows: Integers, position: Array, velocity: Array) -> None:
        """Start some simulations anew, at positions (rows, nq) and velocities (rows, nv)."""
        ids = self._ids(rows)
        self._batch.reset(ids, stage=mujoco.mjtStage.mjSTAGE_NONE.value)
        self.position[rows], self.velocity[rows] = position, velocity

    def advance(self, rows: Integers, period: Integers, command: Array) -> None:
        """Hold commands (rows, nu) for a control period, the so-manieth of each simulation.

        Raises:
            SimulationFailed: MuJoCo refuses to step.
        """
        given = self._given(rows, period, command)
        ids = self._ids(rows)
        try:
            with quiet():
                if not self._acting and given.shape[-1] == 1:
                    self._control[rows] = given[..., 0]
                    self._batch.step(ids, nstep=self._each)
                    return
                for at in range(self._each):
                    self._control[rows] = given[..., min(at, given.shape[-1] - 1)]
                    self._seen.act(self._acting, [None] * len(self._acting))
                    self._batch.step(ids)
        except SimulationError as error:
            raise SimulationFailed(
                f"MuJoCo stopped: {error}",
                where=f"an environment of {self._simulator.robot.name}",
                fix="check the robot's masses and inertias, or take a smaller step",
            ) from error

    def _ids(self, rows: Integers) -> Integers | None:
        return None if len(rows) == len(self.position) else rows

    def _given(self, rows: Integers, period: Integers, command: Array) -> Array:
        """Return what arrives at each step, (rows, nu, steps), or 1 if nothing changes it."""
        if not self._filtered:
            return command[..., None]
        # Delays and lags look back, each row to its own start; what is to come they do not see.
        steps = period[:, None] * self._each + np.arange(self._each)
        self._told[rows[:, None], :, steps] = command[:, None]
        given = np.empty((len(rows), self.model.nu, self._each))
        until = int(steps.max()) + 1
        for actuator in self._simulator.robot.actuators:
            index = self.model.actuator(actuator.name).id
            whole = self._told[rows, index, :until]
            arrived = received(self._simulator.effects, actuator.name, whole, self._simulator.step)
            given[:, index] = np.take_along_axis(arrived, steps, axis=-1)
        return given
