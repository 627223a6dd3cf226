from __future__ import annotations

import numpy as np
import pytest

from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.sensor.sensor_bias import SensorBias
from morph.record.recording import Channel
from morph.sim.drive import held, received, sensed, unsensed


def test_a_held_command_is_averaged_over_a_step_exactly() -> None:
    # 2 until 0.3 s, -1 until 0.5 s, then 4. Steps of 0.4 s from 0.1 s:
    # (0.2 * 2 - 0.2 * 1) / 0.4 = 0.5, then 4 for good.
    channel = Channel(time=np.array([0.0, 0.3, 0.5]), value=np.array([2.0, -1.0, 4.0]), hold=True)
    assert held(channel, 0.1, 0.4, 3) == pytest.approx([0.5, 4.0, 4.0], abs=1e-14)


def test_a_held_command_keeps_its_first_value_before_and_its_last_after() -> None:
    channel = Channel(time=np.array([1.0, 2.0]), value=np.array([3.0, 5.0]), hold=True)
    # The step from 0.75 to 1.25 s lies half before the first sample; all of it holds 3.
    # The one from 1.75 to 2.25 s is half 3 and half 5.
    means = held(channel, -0.25, 0.5, 7)
    assert means == pytest.approx([3.0, 3.0, 3.0, 3.0, 4.0, 5.0, 5.0], abs=1e-14)


def test_the_mean_of_a_held_command_is_exact_on_a_jittered_clock() -> None:
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.001, 0.009, 400))
    value = rng.normal(size=400)
    step, steps, start = 0.0023, 700, 0.05
    got = held(Channel(time=time, value=value, hold=True), start, step, steps)
    # By hand: each sample rules from its stamp to the next one.
    ends = np.append(time[1:], np.inf)
    for n in range(steps):
        low, high = start + n * step, start + (n + 1) * step
        ruled = np.clip(np.minimum(ends, high) - np.maximum(time, low), 0.0, None)
        # Roundoff of sums of 400 terms, over a step of 0.0023: 1e-16 * 400 / 0.0023.
        assert got[n] == pytest.approx(float(ruled @ value) / step, abs=1e-10)


def test_a_whole_held_command_loses_no_impulse() -> None:
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(0.001, 0.009, 200))
    channel = Channel(time=time, value=rng.normal(size=200), hold=True)
    step = 0.0007
    steps = int((time[-1] - time[0]) / step)
    total = step * held(channel, float(time[0]), step, steps).sum()
    end = float(time[0]) + steps * step
    ruled = np.diff(np.minimum(np.append(time, np.inf), end))
    assert total == pytest.approx(float(ruled @ channel.value), abs=1e-12)


def test_effects_act_on_a_command_one_after_the_other() -> None:
    told = np.random.default_rng(2).normal(size=30)
    delay, lag = ActuatorDelay(actuator="a", T=0.01), ActuatorLag(actuator="a", T=0.02)
    both = received((delay, lag), "a", told, 0.002)
    assert np.array_equal(both, lag.command("a", delay.command("a", told, 0.002), 0.002))
    assert np.array_equal(received((delay, lag), "b", told, 0.002), told)


def test_the_truth_behind_a_biased_reading_is_found() -> None:
    bias = SensorBias(channel="hinge.position", bias=0.3)
    truth = np.linspace(-1.0, 1.0, 11)
    reading = sensed((bias,), "hinge.position", truth)
    assert reading == pytest.approx(truth + 0.3, abs=1e-15)
    assert unsensed((bias,), "hinge.position", reading) == pytest.approx(truth, abs=1e-15)
    assert np.array_equal(unsensed((bias,), "knee.position", truth), truth)
