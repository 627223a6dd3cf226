"""Many runs of a task as one Gymnasium vector environment."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from morph.arrays import Array, Integers, Mask
from morph.body.robot import Robot
from morph.errors import TaskError
from morph.physics.effect import Effect
from morph.task.gym.env import Action, spaces_of, task_of
from morph.task.gym.runs import Runs
from morph.task.task import Task


class Environments(VectorEnv[Array, Action, Any]):
    """A task on many copies of a robot, stepped at once: no loop over environments.

    It does what Gymnasium's `SyncVectorEnv` does with as many `Environment`, number for
    number. A run that ended is started anew by the next step, whose action for it is ignored.

    Args:
        task: A task, or the name of one.
        robot: The robot that a named task is asked of: itself, its name or its files.
        num_envs: How many copies.
        effects: What acts on it beyond what the task says.

    Raises:
        RobotError: There is no such robot.
        SimulationFailed: The body or its effects cannot run so.
        TaskError: There is no such task, or the body cannot be asked to do it.
    """

    metadata = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        task: str | Task,
        robot: str | Path | Robot | None = None,
        *,
        num_envs: int = 1,
        effects: tuple[Effect, ...] = (),
    ) -> None:
        """Make the task and compile its body."""
        self.task = task_of(task, robot)
        if num_envs < 1:
            raise TaskError(
                f"{num_envs} environments are asked for",
                where=f"environments of {self.task.robot.name}",
                fix="ask for one or more",
            )
        self.num_envs = num_envs
        self._runs = Runs(self.task, num_envs, effects)
        self.single_observation_space, self.single_action_space = spaces_of(self._runs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._all = np.arange(num_envs)
        self._chance: list[np.random.Generator] = []
        self._over = np.zeros(num_envs, dtype=bool)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Array, dict[str, Any]]:
        """Return what is seen of all runs, started anew; there are no options.

        Args:
            seed: Of the first run, the others' follow; or one for each. Without one, each goes
                on with the chance that it has.
            options: Nothing is taken from them.

        Raises:
            TaskError: There are more or fewer seeds than runs.
        """
        first = seed if isinstance(seed, int) else None
        super().reset(seed=first)
        seeds = [None] * self.num_envs if seed is None else seed
        if isinstance(seeds, int):
            seeds = [seeds + at for at in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise TaskError(
                f"{len(seeds)} seeds are given for {self.num_envs} environments",
                where=f"environments of {self.task.robot.name}",
                fix="give one seed, or one for each",
            )
        had: Sequence[np.random.Generator | None] = self._chance or [None] * self.num_envs
        self._chance = [
            before if one is None and before is not None else np_random(one)[0]
            for one, before in zip(seeds, had, strict=True)
        ]
        self._over[:] = False
        return self._runs.start(self._all, self._chance), {}

    def step(self, actions: Action) -> tuple[Array, Array, Mask, Mask, dict[str, Any]]:
        """Return what is seen after a control period, rewards, and which runs ended and how.

        The last holds what each term cost under `costs` and, of runs that ended, `success`;
        `_costs` and `_success` say of which runs.

        Raises:
            SimulationFailed: An action is no number, or MuJoCo refuses to step.
            TaskError: They were never reset, or a cost is no number.
        """
        if not self._chance:
            raise TaskError(
                "they were never started",
                where=f"environments of {self.task.robot.name}",
                fix="reset them first",
            )
        anew, on = np.flatnonzero(self._over), np.flatnonzero(~self._over)
        seen = np.empty(self.observation_space.shape or ())
        reward = np.zeros(self.num_envs)
        terminated, truncated = np.zeros((2, self.num_envs), dtype=bool)
        info: dict[str, Any] = {}
        if len(on):
            done = self._runs.step(on, np.asarray(actions)[on])
            seen[on] = self._runs.seen(on)
            reward[on] = done.reward
            terminated[on], truncated[on] = done.terminated, done.truncated
            info = {"costs": _spread(done.costs, on, self.num_envs), "_costs": ~self._over}
        if len(anew):
            seen[anew] = self._runs.start(anew, self._chance)
        self._over = terminated | truncated
        if self._over.any():
            success = np.zeros(self.num_envs, dtype=bool)
            success[on] = done.success
            info |= {"success": success, "_success": self._over.copy()}
        return seen, reward, terminated, truncated, info


def _spread(costs: dict[str, Array], rows: Integers, runs: int) -> dict[str, Any]:
    """Return numbers of some runs as those of all, and beside each of which runs they are."""
    spread: dict[str, Any] = {}
    for name, cost in costs.items():
        spread[name], spread[f"_{name}"] = np.zeros(runs), np.zeros(runs, dtype=bool)
        spread[name][rows], spread[f"_{name}"][rows] = cost, True
    return spread
