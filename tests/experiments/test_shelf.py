"""The study of the shelf: what counts as learned, and what servos do by themselves."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from experiments.shelf import headline, is_learned, report, without_policy
from experiments.shelf_hold import held, posture
from morph.arrays import JSON
from morph.body.load import load
from morph.task.tasks import task as task_of


def row(body: str, success: float, *, seconds: float = 5.0, **controls: float) -> JSON:
    record = {
        "succeeded": success >= 0.5,
        "search": {"name": "ddp"},
        "judged": {"success": success, "loss": {"mean": 1.0}},
        "controls": {name.replace("_", " "): {"success": of} for name, of in controls.items()},
    }
    return {"body": body, "task": "stand", "wall_s": seconds, "record": record}


ROWS = [
    row("statue", 1.0, nothing=0.0, random=0.0, posture_held=1.0),
    row("walker", 1.0, nothing=0.1, random=0.5, posture_held=0.94),
    row("slow", 1.0, seconds=601.0, nothing=0.0, random=0.0, posture_held=0.0),
    row("clumsy", 0.2, nothing=0.0, random=0.0, posture_held=0.0),
]


def test_a_task_that_servos_do_alone_is_not_learned() -> None:
    assert [is_learned(each) for each in ROWS] == [False, True, False, False]
    assert without_policy(ROWS[0]) == {"posture held": 1.0}
    said = headline(ROWS)["figures"]
    assert (said["working"], said["learned"], said["done_without_a_policy"]) == (2, 1, 1)
    assert said["done_without_a_policy_by"] == "statue"


def test_the_bodies_that_need_no_policy_are_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert report(ROWS) == 2
    said = capsys.readouterr().out
    assert "2 of 4 bodies have a policy" in said
    assert "1 of these are of tasks that no control does" in said
    assert "not counted as learned: statue, stand (posture held 100%)" in said
    assert "not counted as learned: walker" not in said


def test_the_command_of_a_posture_is_where_servos_start_and_no_effort_of_motors() -> None:
    task = task_of("reach", load("so101"))
    simulator = task.simulator()
    told = posture(task, simulator)
    data = mujoco.MjData(simulator.model)
    data.qpos = task.start.sample(task.robot, simulator.model, 1, None)[0][0]
    for command, actuator in zip(told, task.robot.actuators, strict=True):
        assert command == pytest.approx(data.joint(actuator.joint).qpos[0])
    cartpole = task_of("balance", load("cartpole"))
    assert np.array_equal(posture(cartpole, cartpole.simulator()), [0.0])


def test_a_pole_does_not_balance_by_itself_and_a_humanoid_s_servos_stand() -> None:
    assert held("cartpole", "balance", seed=100, rows=5)["success"] == 0.0
    still = held("humanoid", "stand", seed=100, rows=3)
    assert (still["success"], still["motors"]) == (1.0, 0)
