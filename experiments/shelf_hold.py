"""What servos do by themselves: they hold the posture of the start, and no policy is asked."""

from __future__ import annotations

import mujoco
import numpy as np

from morph.app.report.learn.judge import JUDGING
from morph.arrays import JSON, Array
from morph.body.load import load
from morph.search.evaluate import Score
from morph.sim.simulator import Simulator
from morph.task.run import run
from morph.task.task import Task
from morph.task.tasks import task as task_of

ROWS = 20
"""Runs, from the starts of the first runs that judge a policy."""

SURE = 0.95
"""Share of runs that reach every goal in which a task counts as done."""


def held(body: str, name: str, seed: int, rows: int = ROWS) -> JSON:
    """Return how a body does its task while its servos are told to stay where they start."""
    task = task_of(name, load(body))
    score = hold_posture(task, task.simulator(), seed, rows)
    servos = sum(each.kind == "position" for each in task.robot.actuators)
    return {
        "success": score.share,
        "loss": score.mean,
        "runs": rows,
        "servos": servos,
        "motors": len(task.robot.actuators) - servos,
    }


def hold_posture(task: Task, simulator: Simulator, seed: int, rows: int) -> Score:
    """Return how a task goes under one constant command, that of the start's posture.

    The starts are those by which `morph learn` judges a policy of the same seed.
    """
    told = posture(task, simulator)
    rng = np.random.default_rng([seed, JUDGING])
    position, velocity = task.start.sample(task.robot, simulator.model, rows, rng)

    def act(q: Array, v: Array, now: float) -> Array:
        return np.tile(told, (len(q), 1))

    moved = run(task, simulator, act, position, velocity)
    return Score(loss=task.loss(moved), success=task.succeeded(moved))


def posture(task: Task, simulator: Simulator) -> Array:
    """Return the command of every actuator at the start: a servo's place, and no effort of a motor.

    In the middle of the start; a servo's command is its actuator's length, gear included.
    """
    model = simulator.model
    data = mujoco.MjData(model)
    position, _ = task.start.sample(task.robot, model, 1, None)
    data.qpos = position[0]
    mujoco.mj_forward(model, data)
    servo = np.array([each.kind == "position" for each in task.robot.actuators])
    return np.where(servo, data.actuator_length, 0.0)
