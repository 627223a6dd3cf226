from __future__ import annotations

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.policy_transfer.live.delay import Delay, delay_of
from morph.search.target import Experience, Simulated
from morph.task.task import Task
from morph.task.tasks import task

PUSHES = 8.0 * np.sign(np.sin(0.7 * np.arange(60)))[:, None]


@pytest.fixture(scope="module")
def whole() -> Task:
    return task("swing-up", load("cartpole"))


def shown(whole: Task, seconds: float, seed: int = 100, command: Array = PUSHES) -> Experience:
    late = (ActuatorDelay(actuator="slide", T=seconds),) if seconds else ()
    # Ten times the friction of the description, 0.1 N s/m: the model of the body is wrong too.
    friction = ViscousFriction(joint="slide", b=0.9)
    target = Simulated(task=whole, simulator=whole.simulator((*late, friction)))
    return target.trial(command, np.random.default_rng(seed))


def measured(whole: Task, run: Experience, sign: float = 1.0) -> Delay | None:
    return delay_of(whole.simulator(), run.position, run.velocity, sign * run.command, run.period)


@pytest.mark.parametrize("seconds", [0.03, 0.05, 0.1])
def test_a_delay_is_measured_although_friction_is_tenfold(whole: Task, seconds: float) -> None:
    found = measured(whole, shown(whole, seconds))
    assert found is not None
    assert found.certain
    # Friction acts a little like less delay: 15 ms were seen at most, half a delay of 0.03 s.
    assert found.seconds == pytest.approx(seconds, abs=0.02)


def test_no_delay_is_never_certain(whole: Task) -> None:
    found = [measured(whole, shown(whole, 0.0, seed)) for seed in range(100, 106)]
    assert [each for each in found if each is not None and each.certain] == []


def test_commands_that_are_not_obeyed_have_no_delay(whole: Task) -> None:
    run = shown(whole, 0.05)
    # The control: the same run, its commands with the other sign.
    assert measured(whole, run, sign=-1.0) is None


def test_a_body_that_is_told_nothing_tells_no_delay(whole: Task) -> None:
    assert measured(whole, shown(whole, 0.05, command=np.zeros((60, 1)))) is None
