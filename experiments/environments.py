"""Gymnasium's own check of every environment, and what a batch of them costs beside bare stepping.

`python -m experiments.environments` checks every pair of a robot of the shelf and a task; `--batch`
measures instead. Water is computed for each body anew on a machine that has not met it: seconds.
"""

from __future__ import annotations

import argparse
import time
import warnings
from dataclasses import dataclass

import gymnasium
import mujoco
import numpy as np
from gymnasium.utils.env_checker import check_env
from mujoco.batch import Batch

from morph.errors import MorphError
from morph.task.gym import environment_id, pairs
from morph.task.gym.vector import Environments
from morph.task.tasks import task as task_called


@dataclass(frozen=True, kw_only=True)
class Checked:
    """What the check of one environment found."""

    name: str
    """The environment."""
    found: str
    """What is wrong; nothing if it is clean."""
    seconds: float
    """How long making and checking took, s."""


def checked(name: str) -> Checked:
    """Return what Gymnasium's check finds in an environment; a warning counts."""
    began = time.perf_counter()
    found = ""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            check_env(gymnasium.make(name).unwrapped)
        except (MorphError, AssertionError, Warning, gymnasium.error.Error) as error:
            found = str(error).splitlines()[0]
    return Checked(name=name, found=found, seconds=time.perf_counter() - began)


def batch_seconds(robot: str, task: str, count: int, repeats: int) -> tuple[float, float, int]:
    """Return seconds a control period of a vector environment and of a bare batch, and its steps.

    By turns, the median of some repeats of ten periods each; all runs are at the same time.
    """
    made = Environments(task, robot, num_envs=count)
    made.reset(seed=100)
    made.action_space.seed(100)
    action = made.action_space.sample()
    simulator = task_called(task, made.task.robot).simulator()
    bare = Batch(simulator.model, count, 2)
    bare.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
    control = bare.bind("ctrl")
    rng = np.random.default_rng(100)
    start = made.task.start.sample(made.task.robot, simulator.model, count, rng)
    bare.bind("qpos")[:], bare.bind("qvel")[:] = start
    steps = round(made.task.period / made.task.step)
    spent: list[tuple[float, float]] = []
    for _ in range(repeats):
        began = time.perf_counter()
        for _ in range(10):
            made.step(action)
        between = time.perf_counter()
        for _ in range(10):
            control[:] = action
            bare.step(nstep=steps)
        spent.append((between - began, time.perf_counter() - between))
    ours, theirs = np.median(spent, axis=0) / 10.0
    return float(ours), float(theirs), steps


def main(arguments: list[str] | None = None) -> int:
    """Print the table that is asked for; return how many environments are not clean."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="check only names that hold this")
    parser.add_argument("--batch", type=int, default=0, help="measure so many at once instead")
    asked = parser.parse_args(arguments)
    if asked.batch:
        ours, theirs, steps = batch_seconds("cartpole", "swing-up", asked.batch, 9)
        print(
            f"{asked.batch} cart-poles at once: {asked.batch / ours:.0f} control periods/s, "
            f"{steps * asked.batch / ours:.0f} simulation steps/s; "
            f"{theirs / ours:.2f} of the speed of the bare batch"
        )
        return 0
    unclean = 0
    for robot, task in pairs():
        name = environment_id(robot, task)
        if asked.only in name:
            row = checked(name)
            unclean += bool(row.found)
            print(f"{row.name:45s} {row.seconds:6.1f} s  {row.found or 'clean'}", flush=True)
    print(f"{unclean} not clean")
    return unclean


if __name__ == "__main__":
    raise SystemExit(main())
