"""Every pair of a robot of the shelf and a task of its card, by a name that Gymnasium knows."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import VectorEnv

from morph.body import shelf
from morph.body.card import load_card
from morph.body.robot import Robot
from morph.errors import RobotError
from morph.physics.effect import Effect
from morph.task.gym.env import task_of
from morph.task.task import Task
from morph.task.tasks import TASKS

ENTRY = "morph.task.gym.env:Environment"
"""What makes one environment."""

VECTOR_ENTRY = "morph.task.gym.vector:Environments"
"""What makes many at once."""

IRREGULAR = {"cartpole": "CartPole", "so101": "SO101"}
"""Names that are not written as their parts between underscores would be."""


def environment_id(robot: str, task: str) -> str:
    """Return the name of an environment: `morph/CartPole-SwingUp-v0`.

    Each part of a name begins with a capital letter, whatever stands between the parts.
    """
    return f"morph/{_camel(robot)}-{_camel(task)}-v0"


def _camel(name: str) -> str:
    parts = re.split(r"[^A-Za-z0-9]+", name)
    return IRREGULAR.get(name) or "".join(part[:1].upper() + part[1:] for part in parts)


def pairs() -> Iterator[tuple[str, str]]:
    """Yield each robot of the shelves with each task of its card that there is.

    No robot is loaded; one whose card cannot be read is left out, and `morph inspect` says why.
    """
    for robot in shelf.names():
        try:
            card = load_card(shelf.find(robot) / "card.toml")
        except RobotError:
            continue
        yield from ((robot, task) for task in card.tasks if task in TASKS)


def register_all() -> None:
    """Make every pair known to Gymnasium; a name that it knows already stays what it was."""
    for robot, task in pairs():
        name = environment_id(robot, task)
        if name not in gymnasium.registry:
            gymnasium.register(
                name,
                entry_point=ENTRY,
                vector_entry_point=VECTOR_ENTRY,
                kwargs={"task": task, "robot": robot},
            )


def environment(
    task: str | Task,
    robot: str | Path | Robot | None = None,
    *,
    effects: tuple[Effect, ...] = (),
) -> gymnasium.Env[Any, Any]:
    """Return an environment of any robot, as `gymnasium.make` would.

    Args:
        task: A task, or the name of one.
        robot: The robot that a named task is asked of: itself, its name or its files.
        effects: What acts on it beyond what the task says.

    Raises:
        RobotError: There is no such robot.
        SimulationFailed: The body or its effects cannot run so.
        TaskError: There is no such task, or the body cannot be asked to do it.
    """
    return gymnasium.make(_spec(task_of(task, robot), effects))


def environments(
    task: str | Task,
    robot: str | Path | Robot | None = None,
    *,
    num_envs: int,
    effects: tuple[Effect, ...] = (),
) -> VectorEnv[Any, Any, Any]:
    """Return many environments of any robot in one batch, as `gymnasium.make_vec` would.

    Args:
        task: A task, or the name of one.
        robot: The robot that a named task is asked of: itself, its name or its files.
        num_envs: How many.
        effects: What acts on it beyond what the task says.

    Raises:
        RobotError: There is no such robot.
        SimulationFailed: The body or its effects cannot run so.
        TaskError: There is no such task, or the body cannot be asked to do it.
    """
    return gymnasium.make_vec(_spec(task_of(task, robot), effects), num_envs=num_envs)


def _spec(task: Task, effects: tuple[Effect, ...]) -> EnvSpec:
    return EnvSpec(
        id=environment_id(task.robot.name, task.name),
        entry_point=ENTRY,
        vector_entry_point=VECTOR_ENTRY,
        kwargs={"task": task, "effects": effects},
    )
