from __future__ import annotations

import numpy as np
import pytest

from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.sensor.sensor_bias import SensorBias
from morph.physics.sensor.sensor_scale import SensorScale
from morph.record.recording import Channel
from morph.sim.drive import completed, held, received, sensed, unsensed


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


def test_the_truth_behind_a_scaled_and_biased_reading_is_found() -> None:
    bad = (
        SensorScale(channel="hinge.position", gain=1.3),
        SensorBias(channel="hinge.position", bias=0.3),
    )
    truth = np.linspace(-1.0, 1.0, 11)
    reading = sensed(bad, "hinge.position", truth)
    assert reading == pytest.approx(1.3 * truth + 0.3, abs=1e-15)
    # Two roundings of numbers up to 1.6.
    assert unsensed(bad, "hinge.position", reading) == pytest.approx(truth, abs=1e-15)


def test_the_truth_behind_a_biased_reading_is_found() -> None:
    bias = SensorBias(channel="hinge.position", bias=0.3)
    truth = np.linspace(-1.0, 1.0, 11)
    reading = sensed((bias,), "hinge.position", truth)
    assert reading == pytest.approx(truth + 0.3, abs=1e-15)
    assert unsensed((bias,), "hinge.position", reading) == pytest.approx(truth, abs=1e-15)
    assert np.array_equal(unsensed((bias,), "knee.position", truth), truth)


def _lossy(seconds: float = 20.0) -> tuple[Channel, Channel, list[int]]:
    """Return a smooth command at 50 Hz with a little jitter, the same less four rows, and these."""
    rng = np.random.default_rng(0)
    time = np.cumsum(0.02 * (1.0 + 0.05 * rng.normal(size=round(50 * seconds))))
    whole = Channel(time=time, value=np.sin(3.0 * time) + 0.3 * np.sin(8.0 * time), hold=True)
    lost = [100, 333, 334, 700]
    kept = np.setdiff1d(np.arange(len(time)), lost)
    return whole, Channel(time=time[kept], value=whole.value[kept], hold=True), lost


def test_samples_that_a_logger_lost_are_filled_in() -> None:
    whole, lossy, lost = _lossy()
    filled, error = completed(lossy)
    assert len(filled.time) == len(whole.time)
    # The clock jitters by 1 ms.
    assert filled.time[lost] == pytest.approx(whole.time[lost], abs=4e-3)
    # Waves lie on a line to (w h)^2 / 8, h = 40 ms: 2e-3 and 0.3 * 1.3e-2, on a cubic to less; a
    # slope of at most 5 in 1 ms adds 5e-3. A command held for twice as long errs more.
    assert filled.value[lost] == pytest.approx(whole.value[lost], abs=1e-2)
    assert np.abs(lossy.at(whole.time[lost]) - whole.value[lost]).max() > 4e-2
    logged = np.setdiff1d(np.arange(len(whole.time)), lost)
    assert np.array_equal(filled.value[logged], whole.value[logged])
    assert not error[logged].any()
    assert (error[lost] > 0.0).all()


def test_commands_on_a_clock_of_their_own_are_held() -> None:
    # Logged when it changes, not at a rate: a gap says that it did not change.
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.exponential(0.1, 300))
    event = Channel(time=time, value=rng.normal(size=300), hold=True)
    same, error = completed(event)
    assert same is event
    assert not error.any()
    # A pause of a second at a regular rate is no loss of a few rows either.
    paused = np.concatenate([np.arange(100), np.arange(150, 300)]) * 0.02
    pause = Channel(time=paused, value=np.sin(paused), hold=True)
    assert completed(pause)[0] is pause
