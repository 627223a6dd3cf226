"""The simulation from which a policy comes, as adjusting asks it: what follows, and what leads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.alignment.samples import Transitions
from morph.alignment.states import change
from morph.arrays import Array, Mask
from morph.errors import TransferError
from morph.policy.observing import Observer
from morph.policy.policy import Policy
from morph.search.evaluate import check_period
from morph.search.target import Experience, Simulated
from morph.search.trajectory.plant import Plant
from morph.search.trajectory.tangent import turning
from morph.sim.simulator import Simulator
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedTask:
    """A task and a simulation of it, whose states are (q, v) of hinges and slides.

    Raises:
        TransferError: The body floats: its states are no plain numbers.
        SimulationFailed: The simulation has states beside positions and velocities.
    """

    task: Task
    """What is done; the target does the same."""
    simulator: Simulator
    """The simulation, in which the policy was made."""

    def __post_init__(self) -> None:
        """Check that a state is plain numbers."""
        if self.plant.model.nq != self.plant.model.nv:
            raise TransferError(
                "an adjustment learns from states of hinges and slides, and this body floats",
                where=f"task {self.task.name} of {self.task.robot.name}",
                fix="repair the simulation instead, or make a policy that needs no adjustment",
            )

    @cached_property
    def plant(self) -> Plant:
        """One control period of the simulation, many at once."""
        return Plant(self.simulator, self.task.period)

    @cached_property
    def turns(self) -> Mask:
        """Which numbers of a state are angles that may go round, shape (2 nv,)."""
        result = turning(self.plant.model)
        return np.concatenate([result, np.zeros_like(result)])

    def after(self, state: Array, command: Array) -> Array:
        """Return the states (m, 2 nv) one period after states under commands (m, nu)."""
        nq = self.plant.model.nq
        q, v = self.plant.advance(state[:, :nq], state[:, nq:], command)
        return np.concatenate([q, v], axis=1)

    def inverse(self, state: Array, after: Array) -> Array:
        """Return the commands that lead nearest to the next states, shape (m, nu).

        Two steps of Gauss and Newton: a state moves by a nearly affine function of a command that
        is held. All numbers of a state count alike, as each is seen with the same noise. No bound
        is kept: a source may need more than it has to do what a stronger target did.
        """
        plant = self.plant
        middle, half = 0.5 * (plant.low + plant.high), 0.5 * (plant.high - plant.low)
        each = [middle, *(middle + 0.9 * step for step in np.diag(half))]
        many = np.repeat(state, len(each), axis=0)
        moved = self.after(many, np.tile(np.array(each), (len(state), 1)))
        moved = moved.reshape(len(state), len(each), -1)
        slope = (moved[:, 1:] - moved[:, :1]) / (0.9 * half[:, None])
        inner = slope @ np.swapaxes(slope, 1, 2)
        # An actuator that moves nothing here is told nothing.
        inner += 1e-12 * np.trace(inner, axis1=1, axis2=2)[:, None, None] * np.eye(len(half))
        command = np.tile(middle, (len(state), 1))
        for reached in (moved[:, 0], None):
            if reached is None:
                # Beyond its bounds a command is clamped; from there the slope goes on.
                command = np.clip(command, plant.low, plant.high)
                reached = self.after(state, command)
            away = change(reached, after, self.turns)
            command = command + np.linalg.solve(inner, slope @ away[..., None])[..., 0]
        return np.asarray(command)

    def run(self, policy: Policy, rng: np.random.Generator) -> Experience:
        """Return one run of the source, from a drawn start and seen through its noise."""
        return Simulated(task=self.task, simulator=self.simulator).trial(policy, rng)

    def transitions(self, runs: Sequence[Experience]) -> Transitions:
        """Return all steps of some runs.

        Raises:
            TransferError: There is no run, or it is of another body or another period.
        """
        for each in runs:
            self._check(each)
        if not runs:
            raise TransferError(
                "there is no run to learn from",
                where=f"an adjustment for {self.task.robot.name}",
                fix="run the policy on the target once",
            )
        states = [states_of(each) for each in runs]
        return Transitions(
            state=np.concatenate([x[:-1] for x in states]),
            command=np.concatenate([each.command for each in runs]),
            after=np.concatenate([x[1:] for x in states]),
            turns=self.turns,
        )

    def _check(self, run: Experience) -> None:
        model = self.plant.model
        sizes = (run.position.shape[1], run.velocity.shape[1], run.command.shape[1])
        wanted = (model.nq, model.nv, model.nu)
        if sizes != wanted or abs(run.period - self.task.period) > 1e-9:
            raise TransferError(
                f"a run has {sizes} positions, velocities and commands every {run.period:g} s; "
                f"the source has {wanted} every {self.task.period:g} s",
                where=f"an adjustment for {self.task.robot.name}",
                fix="give runs of the same body at the task's control period",
            )

    def seen(self, policy: Policy, run: Experience) -> tuple[Array, Array]:
        """Return what a policy saw before each command of a run, and the times.

        Shapes (periods, observations) and (periods,).

        Raises:
            SearchError: The policy's control period is not the task's.
        """
        check_period(policy, self.task)
        observer = Observer(policy, self.task.robot, self.plant.model, 1)
        pairs = zip(run.position[:-1], run.velocity[:-1], strict=True)
        seen = [observer.see(q[None], v[None])[0] for q, v in pairs]
        return np.array(seen), np.asarray(run.period * np.arange(len(seen)), dtype=float)


def states_of(run: Experience) -> Array:
    """Return the states (q, v) of a run, shape (samples, nq + nv)."""
    return np.concatenate([run.position, run.velocity], axis=1)
