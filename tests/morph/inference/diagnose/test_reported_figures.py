"""Every figure of one diagnosis, computed anew from its own rollouts and from the truth."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.optimize import least_squares

from morph.arrays import Array
from morph.body.load import load
from morph.inference.diagnose import diagnose
from morph.model.diagnosis import Diagnosis

FRICTION = 0.06
"""N m, beside 4.9 N m of gravity."""
PERIOD = 0.01
WINDOW = 100
"""Readings of a rollout of 1 s."""


@pytest.fixture(scope="module")
def runs(recorded: Callable[..., Any]) -> Any:
    """Three runs to learn from and two held out, of 3 s: two rollouts of 1 s in each of the two."""
    return recorded(friction=FRICTION, seeds=range(5), seconds=3.0)


@pytest.fixture(scope="module")
def found(runs: Any) -> Diagnosis:
    return diagnose(load("pendulum"), runs.recordings[:3], held_out=runs.recordings[3:], seed=0)


def windows(found: Diagnosis, run: int, values: Array) -> Array:
    """Return a trace of a held-out run as rollouts, (rollouts, readings)."""
    time = found.traces[run].time
    assert np.flatnonzero(np.isnan(time)).tolist() == [WINDOW, 2 * WINDOW + 1]
    return values[~np.isnan(time)].reshape(2, WINDOW)


def squares(found: Diagnosis, model: str) -> Array:
    """Return the squared error of each of the four rollouts, by hand from the traces."""
    return np.concatenate(
        [
            np.square(windows(found, k, t.measured) - windows(found, k, t.models[model])).sum(1)
            for k, t in enumerate(found.traces)
        ]
    )


def swing(model: Any, start: Array, commands: Array) -> Array:
    """Return where MuJoCo alone leads a pendulum, a reading each 10 ms."""
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = start
    read = []
    for command in commands:
        data.ctrl[0] = command
        mujoco.mj_step(model, data, nstep=round(PERIOD / model.opt.timestep))
        read.append(float(data.qpos[0]))
    return np.array(read)


def test_the_true_pendulum_keeps_what_the_motor_gives_but_for_friction(runs: Any) -> None:
    q, v = runs.path[:, 0], runs.path[:, 1]
    energy = 0.5 * 0.251 * v**2 - 9.81 * 0.5 * np.cos(q)
    way = np.diff(q, axis=0)
    # A command is held from reading to reading: its work is the command times the way.
    told = np.column_stack([recording["hinge.command"][:-1] for recording in runs.recordings])
    work = np.cumsum(told * way - FRICTION * np.abs(way), axis=0)
    # Readings miss up to twice 10 rad/s2 * (10 ms)^2 / 8 of the way at each of some ten turns:
    # 1.5e-4 J. The step allows (5 rad/s * 0.5 ms)^2 = 6e-6 of 4 J. Friction takes 0.14 J or more.
    np.testing.assert_allclose(energy[1:] - energy[0], work, atol=2e-4)


def test_traces_hold_the_readings_of_the_held_out_runs(runs: Any, found: Diagnosis) -> None:
    assert [t.episode for t in found.traces] == ["run_3", "run_4"]
    for recording, trace in zip(runs.recordings[3:], found.traces, strict=True):
        there = ~np.isnan(trace.time)
        at = np.round(trace.time[there] / PERIOD).astype(int)
        assert at[0] == 16  # The first rollout starts 0.15 s into the run.
        assert trace.time[there] == pytest.approx(at * PERIOD, abs=1e-9)
        assert trace.measured[there] == pytest.approx(recording["hinge.position"][at], abs=1e-12)


@pytest.mark.parametrize("model", ["nominal", "corrected"])
def test_the_reported_error_is_that_of_the_description_simulated_by_mujoco_alone(
    runs: Any, found: Diagnosis, model: str
) -> None:
    mjcf = load("pendulum").mjcf if model == "nominal" else found.corrected
    body = mujoco.MjModel.from_xml_string(mjcf)
    body.opt.timestep = 1e-3
    total = 0.0
    for run, trace in enumerate(found.traces):
        recording = runs.recordings[3 + run]
        times, told = windows(found, run, trace.time), windows(found, run, trace.models[model])
        for time, predicted, measured in zip(
            times, told, windows(found, run, trace.measured), strict=True
        ):
            first = round(time[0] / PERIOD) - 1
            commands = recording["hinge.command"][first : first + WINDOW]
            state = runs.path[first, :, 3 + run]
            # Where the rollout began was estimated: the two numbers that lead to its own trace.
            begin = least_squares(
                lambda x, u=commands, p=predicted: swing(body, x, u) - p, state, diff_step=1e-4
            ).x
            simulated = swing(body, begin, commands)
            # Commands act for 10 ms here and are centred on steps of 3.3 ms there: half a step at
            # 2 rad/s2 for a part of a second is up to 1e-3 rad.
            assert simulated == pytest.approx(predicted, abs=1e-3)
            total += float(np.square(simulated - measured).sum())
    by_hand = np.sqrt(total / (4 * WINDOW))
    # That difference, in part against the error: 5e-4 rad; half of either error is more.
    assert by_hand > 1.1e-3
    assert found.held_out_rmse[model]["hinge.position"] == pytest.approx(by_hand, abs=5e-4)


def test_the_nominal_error_is_that_of_the_closed_form(runs: Any, found: Diagnosis) -> None:
    off = []
    for run, trace in enumerate(found.traces):
        for time, measured in zip(
            windows(found, run, trace.time), windows(found, run, trace.measured), strict=True
        ):
            free = runs.described(3 + run, round(time[0] / PERIOD) - 1, WINDOW)
            off.append(np.square(measured - free))
    by_hand = float(np.sqrt(np.mean(off)))
    # Starts are true here and estimated there: that is worth 1.5e-3 rad, the error of the
    # corrected model, beside about 1.5e-2; at worst all in step.
    assert by_hand > 0.01
    assert found.held_out_rmse["nominal"]["hinge.position"] == pytest.approx(by_hand, rel=0.15)


@pytest.mark.parametrize("model", ["nominal", "refitted", "corrected"])
def test_reported_errors_are_the_root_mean_square_of_their_traces(
    found: Diagnosis, model: str
) -> None:
    by_hand = np.sqrt(squares(found, model).sum() / (4 * WINDOW))
    assert found.held_out_rmse[model]["hinge.position"] == pytest.approx(by_hand, rel=1e-9)


def test_the_noise_is_that_of_the_readings(found: Diagnosis) -> None:
    # 300 readings a run tell a standard deviation of 3e-4 to 1 / sqrt(600) = 4 %, and what is
    # above the band of the motion is only part of it.
    assert found.held_out_rmse["noise_floor"]["hinge.position"] == pytest.approx(3e-4, rel=0.25)


def test_the_surely_gained_share_is_the_lower_end_of_a_bootstrap_over_rollouts(
    found: Diagnosis,
) -> None:
    before, after = squares(found, "nominal"), squares(found, "corrected")
    # All 4^4 ways to draw four rollouts again, each as likely as another.
    draws = np.array(list(product(range(4), repeat=4)))
    share = 1.0 - after[draws].sum(axis=1) / before[draws].sum(axis=1)
    # 2000 draws tell a quantile of 5 % within four times sqrt(0.05 * 0.95 / 2000) = 2 %.
    low, high = np.quantile(share, [0.03, 0.07])
    assert low - 1e-9 <= found.improvement_low90 <= high + 1e-9
    assert found.improvement_low90 < np.quantile(share, 0.5)


def test_the_worst_stretches_are_those_with_the_greatest_share_of_the_refitted_error(
    found: Diagnosis,
) -> None:
    error = squares(found, "refitted")
    order = np.argsort(-error)
    times = found.located.times
    assert [s.share for s in times] == pytest.approx((error / error.sum())[order].tolist())
    assert [s.episode for s in times] == [f"run_{3 + k // 2}" for k in order]
    assert [s.start for s in times] == pytest.approx([0.15 + k % 2 for k in order])
    assert [s.end - s.start for s in times] == pytest.approx([1.0] * 4)
    assert found.located.channels == pytest.approx({"hinge.position": 1.0})


def test_the_interval_holds_the_friction_with_room_on_both_sides(found: Diagnosis) -> None:
    (finding,) = found.findings
    assert finding.effect.label == "coulomb_friction@hinge"
    c = finding.parameters["c"]
    assert c.low90 < FRICTION < c.high90
    # No bound is near, so that the interval is symmetric. Friction, mass and gain may all be off by
    # one factor: mass is known to 10 %, gain to 5 %, together to (1 / 0.1^2 + 1 / 0.05^2)^-0.5 =
    # 4.5 %, and 1.645 of those are 7.4 %; a temperature of 2 doubles the variance: 10.4 %.
    assert c.value - c.low90 == pytest.approx(c.high90 - c.value, rel=1e-6)
    assert c.high90 - c.value == pytest.approx(0.104 * FRICTION, rel=0.15)
    assert c.unit == "N m"


def test_factors_of_a_description_that_is_right_are_one_and_have_both_ends(
    found: Diagnosis,
) -> None:
    # Mass and gain move together unseen, each within its trust of 10 and 5 %.
    for estimate in found.refit.values():
        assert estimate.value == pytest.approx(1.0, abs=0.02)
        assert 0.9 <= estimate.low90 < estimate.value < estimate.high90 <= 1.1
    assert found.refit["mass:rod"].low90 < 1.0 < found.refit["mass:rod"].high90
    assert found.refit["gain:hinge"].low90 < 1.0 < found.refit["gain:hinge"].high90


def test_what_explains_almost_all_of_the_training_error_is_near_certain(found: Diagnosis) -> None:
    (finding,) = found.findings
    # Laws that hold it as a limit, as Stribeck's, are a few nats less likely each.
    assert found.probabilities["coulomb_friction@hinge"] > 0.6
    assert found.probabilities["none"] < 0.05
    assert finding.probability > 0.6
    assert all(rival.probability < 0.35 for rival in finding.rivals)
    # Held-out squared errors fall by (1.5e-2 / 1.5e-3)^2, a hundred times; those of training,
    # cross-validated, no less than ten times.
    assert 0.9 < finding.gain < 1.0
    assert finding.episodes == ("run_0", "run_1", "run_2")
    assert {rival.effect.split("_")[-1] for rival in finding.rivals} <= {"friction", "hysteresis"}


def test_samples_and_rollouts_are_counted(found: Diagnosis) -> None:
    # Five runs of 301 readings; three rollouts of 1 s in each training run, two in each other.
    assert found.data["samples"] == 5 * 301
    assert (found.data["rollouts_fitted"], found.data["rollouts_scored"]) == (9, 4)
    assert (found.train, found.held_out) == (("run_0", "run_1", "run_2"), ("run_3", "run_4"))
    assert found.split == "as named"


def test_friction_stands_in_the_corrected_description(found: Diagnosis) -> None:
    model = mujoco.MjModel.from_xml_string(found.corrected)
    c = found.findings[0].parameters["c"].value
    assert float(model.dof_frictionloss[0]) == pytest.approx(c, rel=1e-5)
    assert found.corrected_effects == ()
