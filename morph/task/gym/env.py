"""One run of a task as a Gymnasium environment."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Space
from numpy.typing import NDArray

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import TaskError
from morph.physics.effect import Effect
from morph.task.gym.runs import Runs
from morph.task.gym.spaces import MOST
from morph.task.task import Task
from morph.task.tasks import task as task_called

Action = NDArray[np.float32]
"""What an agent gives, from -1 to 1 for each actuator."""


class Environment(gymnasium.Env[Array, Action]):
    """A task on a robot; `docs/gym.md` says what is observed, done and rewarded.

    Args:
        task: A task, or the name of one.
        robot: The robot that a named task is asked of: itself, its name or its files.
        effects: What acts on it beyond what the task says.

    Raises:
        RobotError: There is no such robot.
        SimulationFailed: The body or its effects cannot run so.
        TaskError: There is no such task, or the body cannot be asked to do it.
    """

    metadata = {"render_modes": []}  # noqa: RUF012  # Gymnasium's own annotation stands.

    def __init__(
        self,
        task: str | Task,
        robot: str | Path | Robot | None = None,
        *,
        effects: tuple[Effect, ...] = (),
    ) -> None:
        """Make the task and compile its body."""
        self.task = task_of(task, robot)
        self._runs = Runs(self.task, 1, effects)
        self.observation_space, self.action_space = spaces_of(self._runs)
        self._row = np.zeros(1, dtype=np.int64)
        self._goes = False

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Return what is seen of a new run, and nothing besides; there are no options."""
        super().reset(seed=seed)
        self._goes = True
        return self._runs.start(self._row, [self.np_random])[0], {}

    def step(self, action: Action) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Return what is seen after a control period, the reward, whether and how it ended.

        The last is what each term cost and, at the end, whether every goal was reached.

        Raises:
            SimulationFailed: The action is no number, or MuJoCo refuses to step.
            TaskError: No run goes on, or a cost is no number.
        """
        if not self._goes:
            raise TaskError(
                "its run is over", where=f"an environment of {self.task.robot.name}", fix="reset it"
            )
        done = self._runs.step(self._row, np.asarray(action)[None])
        info: dict[str, Any] = {
            "costs": {name: float(cost[0]) for name, cost in done.costs.items()}
        }
        terminated, truncated = bool(done.terminated[0]), bool(done.truncated[0])
        if terminated or truncated:
            self._goes = False
            info["success"] = bool(done.success[0])
        seen = self._runs.seen(self._row)[0]
        return seen, float(done.reward[0]), terminated, truncated, info


def task_of(task: str | Task, robot: str | Path | Robot | None) -> Task:
    """Return a task by its name, of a robot by its name or its files.

    Raises:
        RobotError: There is no such robot.
        TaskError: There is no such task, the body cannot be asked to do it, or none is given.
    """
    if isinstance(task, Task):
        return task
    if robot is None:
        raise TaskError(
            "no robot is given", where=f"an environment of task {task}", fix="name a robot"
        )
    return task_called(task, robot if isinstance(robot, Robot) else load(robot))


def spaces_of(runs: Runs) -> tuple[Space[Array], Space[Action]]:
    """Return what one run may show, and what it may be told."""
    seen, command = runs.sizes
    most, one = np.full(seen, MOST), np.ones(command, dtype=np.float32)
    observation: Space[Any] = Box(-most, most, dtype=np.float64)
    action: Space[Any] = Box(-one, one, dtype=np.float32)
    return observation, action
