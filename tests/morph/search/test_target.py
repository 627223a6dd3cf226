"""Trials: what is recorded is what was seen, through whatever sensors there are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import SearchError, SimulationFailed
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.effect import Effect
from morph.physics.joint.hysteresis import Hysteresis
from morph.physics.sensor.sensor_bias import SensorBias
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.search.evaluate import attempt, evaluate
from morph.search.target import Simulated
from morph.search.trajectory.plant import Plant
from morph.task.task import Task
from morph.task.tasks import task

GAIN = np.array([[1.0, 0.2, 1.0, 0.1]])


@pytest.fixture(scope="module")
def swing() -> Task:
    return task("swing-up", load("cartpole"))


@pytest.fixture(scope="module")
def linear(swing: Task) -> Linear:
    return Linear(
        action=actions_of(swing.robot),
        observation=observations_of(swing.robot),
        period=swing.period,
        weight=GAIN,
        bias=np.zeros(1),
    )


def test_a_trial_records_the_very_readings_that_the_policy_acted_on(
    swing: Task, linear: Linear
) -> None:
    target = Simulated(task=swing, simulator=swing.simulator())
    shown = target.trial(linear, np.random.default_rng(1))
    seen = np.concatenate([shown.position, shown.velocity], axis=1)[:-1]
    np.testing.assert_allclose(shown.command, np.clip(seen @ GAIN.T, -10, 10), atol=1e-12)


def test_a_biased_sensor_is_seen_and_recorded_biased(swing: Task, linear: Linear) -> None:
    quiet = replace(swing, noise=0.0)
    bias = SensorBias(channel="hinge.position", bias=0.3)
    straight, biased = quiet.simulator(), quiet.simulator((bias,))
    zero = np.zeros((60, 1))
    shown = [
        Simulated(task=quiet, simulator=each).trial(zero, np.random.default_rng(2))
        for each in (straight, biased)
    ]
    np.testing.assert_allclose(shown[1].position - shown[0].position, [[0.0, 0.3]] * 61, atol=1e-12)
    told = [
        attempt(quiet, linear, each, rows=1, rng=np.random.default_rng(3)).command[0, 0, 0]
        for each in (straight, biased)
    ]
    # The gain on the hinge is 0.2: 0.2 * 0.3 = 0.06 N more.
    assert told[1] - told[0] == pytest.approx(0.06, abs=1e-12)


def test_a_policy_of_another_period_is_refused(swing: Task, linear: Linear) -> None:
    other = replace(linear, period=0.01)
    with pytest.raises(SearchError, match=r"every 0.01 s, and the task counts every 0.05 s"):
        evaluate(swing, other, swing.simulator(), rng=np.random.default_rng(0), rows=2)


@pytest.mark.parametrize(
    "effect", [ActuatorDelay(actuator="slide", T=0.05), Hysteresis(joint="hinge", c=0.1)]
)
def test_a_plan_refuses_what_depends_on_the_past(swing: Task, effect: Effect) -> None:
    with pytest.raises(SimulationFailed, match=f"{effect.label} remembers the past"):
        Plant(swing.simulator((effect,)), swing.period)
