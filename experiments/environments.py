"""Gymnasium's own check of every environment, and what a batch of them costs beside bare stepping.

`python -m experiments.environments` checks every pair of a robot of the shelf and a task; `--batch`
measures instead. Water is computed for each body anew on a machine that has not met it: seconds.
Control: a clean environment with one defect each, all of which the check must name.
"""

from __future__ import annotations

import argparse
import math
import time
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import gymnasium
import mujoco
import numpy as np
from gymnasium.utils.env_checker import check_env
from mujoco.batch import Batch

from experiments.figures.save_options import parse_and_save
from morph.arrays import Array
from morph.errors import MorphError
from morph.task.gym import environment_id, pairs
from morph.task.gym.env import Action, Environment
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


class SpoiledEnvironment(Environment):
    """A cart-pole's environment with one defect, which Gymnasium's check must name."""

    defect = ""

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Return the first observation, with the defect in it."""
        seen, info = super().reset(seed=None if self.defect == "seed ignored" else seed)
        if self.defect == "observation outside its space":
            return seen + 1e9, info
        return seen.astype(
            np.float16
        ) if self.defect == "observation of another type" else seen, info

    def step(self, action: Action) -> tuple[Array, Any, bool, bool, dict[str, Any]]:
        """Return what a step gives, with the defect in it."""
        seen, reward, terminated, truncated, info = super().step(action)
        return (
            seen,
            math.nan if self.defect == "reward no number" else reward,
            terminated,
            truncated,
            info,
        )


DEFECTS = (
    "seed ignored",
    "observation outside its space",
    "observation of another type",
    "reward no number",
)
"""Each is planted alone."""


def spoiled(defect: str) -> Checked:
    """Return what Gymnasium's check finds in an environment with a planted defect."""
    environment = SpoiledEnvironment("swing-up", "cartpole")
    environment.defect = defect
    # Without a specification the check warns of that alone.
    environment.spec = gymnasium.spec(environment_id("cartpole", "swing-up"))
    return _checked(f"cart-pole with {defect}", lambda: environment)


def checked(name: str) -> Checked:
    """Return what Gymnasium's check finds in an environment; a warning counts."""
    return _checked(name, lambda: gymnasium.make(name).unwrapped)


def _checked(name: str, make: Callable[[], gymnasium.Env[Any, Any]]) -> Checked:
    began = time.perf_counter()
    found = ""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            check_env(make())
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
    parser = argparse.ArgumentParser(prog="python -m experiments.environments", description=__doc__)
    parser.add_argument("--only", default="", help="check only names that hold this")
    parser.add_argument("--batch", type=int, default=0, help="measure so many at once instead")
    asked, save = parse_and_save(parser, arguments, module="experiments.environments")
    if asked.batch:
        ours, theirs, steps = batch_seconds("cartpole", "swing-up", asked.batch, 9)
        if save:
            speed = {"steps_per_second": steps * asked.batch / ours, "of_bare": theirs / ours}
            bare = {"bare stepping": {"steps_per_second": steps * asked.batch / theirs}}
            save(figures={"environments": asked.batch} | speed, controls=bare)
        print(
            f"{asked.batch} cart-poles at once: {asked.batch / ours:.0f} control periods/s, "
            f"{steps * asked.batch / ours:.0f} simulation steps/s; "
            f"{theirs / ours:.2f} of the speed of the bare batch"
        )
        return 0
    rows = []
    for robot, task in pairs():
        name = environment_id(robot, task)
        if asked.only in name:
            rows.append(row := checked(name))
            print(f"{row.name:45s} {row.seconds:6.1f} s  {row.found or 'clean'}", flush=True)
    unclean = sum(bool(row.found) for row in rows)
    if save:
        figures = {"environments": len(rows), "clean": len(rows) - unclean}
        planted = [spoiled(defect) for defect in DEFECTS]
        named = sum(bool(each.found) for each in planted)
        controls = {
            "defects planted in a clean environment": {"planted": len(planted), "named": named}
        }
        save(figures=figures, controls=controls, rows=[asdict(row) for row in (*rows, *planted)])
    print(f"{unclean} not clean")
    return unclean


if __name__ == "__main__":
    raise SystemExit(main())
