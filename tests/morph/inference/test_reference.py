"""Motion and missing force against a pendulum that SciPy integrates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from morph.arrays import Array
from morph.body.load import load
from morph.inference import reference as module
from morph.inference.reference import reference
from morph.inference.sampled import FLOOR, SampledRun, outliers
from morph.model.measurement import Measurement

H, NOISE = 0.004, 2e-3
PENDULUM = """
<mujoco><compiler angle="radian"/><option timestep="0.004"/><worldbody><body>
  <joint name="hinge" axis="0 1 0"/>
  <inertial pos="0 0 -0.5" mass="2" diaginertia="0.02 0.02 0.02"/>
</body></worldbody><actuator><motor joint="hinge"/></actuator></mujoco>
"""
INERTIA, WEIGHT = 2.0 * 0.25 + 0.02, 2.0 * 9.81 * 0.5


def swing(missing: Callable[[float], float], seconds: float = 6.0) -> dict[str, Any]:
    """Return a driven swing with a force that the model lacks, read with noise at 125 Hz."""
    command = lambda t: 3.0 * np.sin(2.1 * t) + np.sin(5.3 * t)  # noqa: E731

    def rates(t: float, state: Array) -> list[float]:
        q, v = state
        # The axis is y: a positive angle swings the mass to -x.
        return [v, (command(t) + missing(t) - WEIGHT * np.sin(q)) / INERTIA]

    time = H * np.arange(round(seconds / H))
    found = solve_ivp(rates, (0.0, time[-1]), [0.4, 0.0], t_eval=time, rtol=1e-10, atol=1e-12)
    rng = np.random.default_rng(3)
    valid = np.zeros((len(time), 1), dtype=bool)
    valid[::2] = True
    return {
        "time": time,
        "position": found.y[0],
        "velocity": found.y[1],
        "run": SampledRun(
            measurement=Measurement.of(load("pendulum")),
            rates=np.zeros(0, dtype=int),
            attitude=np.zeros((len(time), 0, 4)),
            step=H,
            command=command(time)[:, None],
            reading=found.y[:1].T + NOISE * rng.normal(size=(len(time), 1)),
            valid=valid,
            placed=found.y[:1].T,
            noise=np.array([NOISE]),
            guess=np.zeros(1),
        ),
    }


def guess(case: dict[str, Any]) -> Array:
    """Return positions on lines between readings."""
    run, time = case["run"], case["time"]
    at = run.valid[:, 0]
    return np.interp(time, time[at], run.reading[at, 0])[:, None]


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    """The pendulum as described."""
    return mujoco.MjModel.from_xml_string(PENDULUM)


def test_the_true_model_recovers_the_motion(model: mujoco.MjModel) -> None:
    case = swing(lambda t: 0.0)
    found = reference(model, case["run"], guess(case))
    off = found.position[:, 0] - case["position"]
    # 750 readings of two unknowns, the first position and velocity: an error near
    # 2e-3 sqrt(2 / 750) = 1e-4 rad, and what a step of 4 ms costs.
    assert np.sqrt(np.mean(off**2)) < 4e-4
    # Differences of readings are off by 2e-3 sqrt(2) / 8 ms = 0.35 rad/s.
    assert np.sqrt(np.mean((found.velocity[:, 0] - case["velocity"]) ** 2)) < 0.02
    assert found.disturbance.noise[0] == pytest.approx(NOISE, rel=0.1)
    assert np.sqrt(np.mean(found.force**2)) < 0.05


def test_the_missing_force_is_recovered_along_the_run(model: mujoco.MjModel) -> None:
    missing = lambda t: 0.8 * np.sin(1.3 * t)  # noqa: E731
    case = swing(missing)
    found = reference(model, case["run"], guess(case))
    inside = slice(100, -100)
    off = found.force[inside, 0] - missing(case["time"])[inside]
    assert np.sqrt(np.mean(off**2)) < 0.15
    wrong = found.force[inside, 0] + missing(case["time"])[inside]
    assert np.sqrt(np.mean(wrong**2)) > 0.8


def test_the_missing_force_has_a_floor_relative_to_the_effort(
    model: mujoco.MjModel,
) -> None:
    case = swing(lambda t: 0.0)
    found = reference(model, case["run"], guess(case))
    needed = INERTIA * np.gradient(case["velocity"], H)
    # The slope of smoothed velocities; at the ends of the run it is a line's.
    assert found.inertial[0] == pytest.approx(np.sqrt(np.mean(needed**2)), rel=0.03)
    assert found.leaving(0.0).scale == pytest.approx(FLOOR * found.inertial)
    assert found.leaving(1.0).scale == pytest.approx(found.disturbance.scale)


def test_the_motion_is_that_of_a_semi_implicit_integrator(model: mujoco.MjModel) -> None:
    case = swing(lambda t: 0.3)
    found = reference(model, case["run"], guess(case))
    assert np.allclose(np.diff(found.position, axis=0), H * found.velocity[1:], atol=1e-9)


def test_readings_between_samples_are_compared_with_the_motion_there(
    model: mujoco.MjModel,
) -> None:
    case = swing(lambda t: 0.0)
    rng, run = np.random.default_rng(3), case["run"]
    between = CubicHermiteSpline(case["time"], case["position"], case["velocity"])
    offset = rng.uniform(-0.5 * H, 0.5 * H, (len(case["time"]), 1))
    noise = 1e-4 * rng.normal(size=offset.shape)
    reading = between(case["time"][:, None] + offset) + noise
    told = replace(run, reading=reading, time_offset=offset, noise=np.array([1e-4]))
    found = reference(model, told, case["position"][:, None])
    at = run.valid[:, 0]
    # At 2 rad/s a reading 1 ms late is 2e-3 off: twenty times the noise.
    assert np.sqrt(np.mean(found.error[at] ** 2)) < 1.5e-4
    without = reference(model, replace(told, time_offset=0.0), case["position"][:, None])
    # Without the offsets, errors of time look like noise and vibration that the readings lack.
    assert found.disturbance.scale[0] == pytest.approx(FLOOR * found.inertial[0])
    given, needed = found.disturbance, without.disturbance
    assert given.vibration is not None
    assert needed.vibration is not None
    assert given.vibration[0] + given.noise[0] < 2e-4
    assert needed.vibration[0] + needed.noise[0] > 4e-4


def test_a_reading_far_from_its_neighbours_is_left_out(model: mujoco.MjModel) -> None:
    case = swing(lambda t: 0.0)
    run, reading = case["run"], case["run"].reading.copy()
    wrong = np.flatnonzero(run.valid[:, 0])[[50, 200, 201, 500]]
    reading[wrong, 0] += NOISE * np.array([12.0, 40.0, 40.0, -12.0])
    found = reference(model, replace(run, reading=reading), guess(case))
    left = np.flatnonzero(run.valid[:, 0] & ~found.tangent.valid[:, 0])
    # Two neighbours may be a real motion. Of 750 one is 5 deviations off in 1 of 2,000 runs.
    assert list(left) == [wrong[0], wrong[3]]


def test_a_similar_model_leaves_out_what_the_first_left_out(model: mujoco.MjModel) -> None:
    case = swing(lambda t: 0.0)
    run, reading = case["run"], case["run"].reading.copy()
    wrong = np.flatnonzero(run.valid[:, 0])[[50, 500]]
    reading[wrong[0], 0] += 12.0 * NOISE
    first = reference(model, replace(run, reading=reading), guess(case))
    reading[wrong[1], 0] -= 12.0 * NOISE
    again = reference(model, replace(run, reading=reading), guess(case), before=first)
    left = np.flatnonzero(run.valid[:, 0] & ~again.tangent.valid[:, 0])
    assert list(left) == [wrong[0]]


def test_an_outlier_is_judged_by_the_errors_around_it() -> None:
    rng = np.random.default_rng(0)
    error = rng.normal(size=(400, 1)) * np.where(np.arange(400)[:, None] < 200, 1.0, 10.0)
    error[[100, 300]] = 15.0
    error[[99, 101, 299, 301]] = 0.0
    valid = np.ones_like(error, dtype=bool)
    found = np.flatnonzero(outliers(error, valid))
    assert 100 in found
    assert 300 not in found


def test_a_model_moved_along_its_own_motion_is_the_same() -> None:
    case = swing(lambda t: 0.3)
    # Damping of 40 N m s/rad over 0.52 kg m2: half a step of it slows by 15 %.
    damped = mujoco.MjModel.from_xml_string(PENDULUM)
    damped.dof_damping[0] = 40.0
    run = replace(case["run"], force=np.sin(case["time"])[:, None])
    found = reference(damped, run, guess(case))
    again = module._moved(found, damped, replace(run, valid=found.tangent.valid))
    assert np.allclose(again.acceleration, found.acceleration, atol=1e-6)
    assert np.allclose(again.error, found.error, atol=1e-12)


def test_commands_that_are_unsure_shake_the_joint(model: mujoco.MjModel) -> None:
    case = swing(lambda t: 0.0)
    run = case["run"]
    unsure = np.zeros_like(run.command)
    unsure[100] = 2.0 * H
    found = reference(model, replace(run, unsure=unsure), guess(case))
    jolt = found.disturbance.jolt
    assert jolt is not None
    # 2 N m for one step.
    assert jolt[100, 0, 0] == pytest.approx(2.0 * H / INERTIA, rel=1e-6)
    assert np.flatnonzero(jolt[:, 0, 0]).tolist() == [100]
