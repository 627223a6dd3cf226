"""Which gains count: material, sure, and not at the expense of another fold."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.robot import Robot
from morph.inference.explained import at_noise, certain, evidence_decides
from morph.inference.validate import Validation
from morph.model.episodes import Episode, episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.segments import cut
from morph.model.shooting import predict
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.physics.sensor.timestamp_offset import TimestampOffset
from morph.record.recording import Recording


@pytest.fixture(scope="module")
def episodes(pendulum: Robot, recorded: Callable[..., Recording]) -> list[Episode]:
    runs = [
        recorded(pendulum, seconds=5.0, seed=k, name=f"run_{k}", start={"hinge": 0.5})
        for k in range(4)
    ]
    return [episode(run, pendulum, step_for(runs, pendulum)) for run in runs]


@pytest.fixture(scope="module")
def validation(episodes: list[Episode]) -> Validation:
    return Validation.of(episodes)


def losses(validation: Validation, by_fold: tuple[float, ...], spread: float = 0.1) -> Array:
    """Return losses of stretches about a mean for each fold."""
    rng = np.random.default_rng(0)
    return np.array(by_fold)[validation.fold] + spread * rng.normal(size=len(validation.fold))


def test_runs_are_folds_where_there_are_four(validation: Validation) -> None:
    assert validation.blocks == 1
    assert validation.fold.tolist() == validation.segments.episode.tolist()
    assert len(validation.segments) == 4 * 5


def test_one_run_is_divided_into_four(episodes: list[Episode]) -> None:
    alone = Validation.of(episodes[:1])
    assert alone.blocks == 4
    # Five stretches of 1 s, in the middles of quarters of 1.25 s: 0.5, 1.5, 2.5, 3.5 and 4.5 s.
    assert alone.fold.tolist() == [0, 1, 2, 2, 3]


@pytest.mark.parametrize(
    ("by_fold", "spread", "sure"),
    [
        ((0.5, 0.4, 0.6, 0.5), 0.1, True),
        # All in one run, and none loses: a law may act in one run alone.
        ((2.0, 0.0, 0.0, 0.0), 0.01, True),
        # One run loses more than half of what the others gain.
        ((0.7, 1.0, 0.0, -1.1), 0.1, False),
        # A hundredth of the error's size.
        ((0.01, 0.01, 0.01, 0.01), 0.001, False),
        # 0.1 beside a standard error of 2 / sqrt(20) = 0.45.
        ((0.1, 0.1, 0.1, 0.1), 2.0, False),
    ],
)
def test_a_gain_is_material_sure_and_at_no_folds_expense(
    validation: Validation, by_fold: tuple[float, ...], spread: float, sure: bool
) -> None:
    before = losses(validation, (3.0,) * 4, 0.0)
    assert validation.sure(before, before - losses(validation, by_fold, spread)) == sure


def test_a_sure_gain_at_one_folds_expense_does_not_count(
    pendulum: Robot, recorded: Callable[..., Recording]
) -> None:
    runs = [
        recorded(pendulum, seconds=15.0, seed=k, name=f"run_{k}", start={"hinge": 0.5})
        for k in range(4)
    ]
    long = Validation.of([episode(run, pendulum, step_for(runs, pendulum)) for run in runs])
    before = losses(long, (3.0,) * 4, 0.0)
    # (3 - h) / 4 nats in the mean with a standard error of 0.15 over 60 stretches: 2.4 and 2.7 of
    # them. One run loses 0.53 or 0.47 of what three gain.
    assert not long.sure(before, before - losses(long, (1.0, 1.0, 1.0, -1.6), 0.0))
    assert long.sure(before, before - losses(long, (1.0, 1.0, 1.0, -1.4), 0.0))


def test_a_loss_that_rises_in_the_mean_is_worse(validation: Validation) -> None:
    before = losses(validation, (3.0,) * 4, 0.0)
    assert validation.worse(before, before + losses(validation, (0.7, 1.0, 0.0, -0.4)))
    assert not validation.worse(before, before - losses(validation, (0.5,) * 4))


def test_neither_nothing_nor_a_time_far_below_the_period_of_readings_is_claimed(
    validation: Validation,
) -> None:
    # Readings come every 5 ms: 1 ms is a fifth of that.
    assert validation.idle(ActuatorDelay(actuator="hinge", T=0.0009))
    assert not validation.idle(ActuatorDelay(actuator="hinge", T=0.0011))
    assert not validation.idle(ViscousFriction(joint="hinge", b=1e-6))
    assert validation.idle(ViscousFriction(joint="hinge", b=0.0))


def test_a_reading_that_is_late_is_predicted_late(pendulum: Robot, episodes: list[Episode]) -> None:
    late = TimestampOffset(channel="hinge.position", T=0.05)
    hypothesis = Hypothesis(robot=pendulum, step=episodes[0].step, knobs=(), effects=(late,))
    segments = cut(episodes, 1.0)
    # The pendulum as if its readings were 50 ms late, from the start on.
    start = segments.start.copy()
    read = predict(hypothesis, segments, [hypothesis.start], [start])[0]
    on_time = replace(hypothesis, effects=())
    later = np.full(len(segments), 0.05)
    start += np.stack([segments.grown(at, later) for at in (0, 1)], axis=1)
    same = predict(on_time, segments, [on_time.start], [start])[0]
    at = (segments.before + segments.part) * segments.step
    for row in range(len(segments)):
        # The first 50 ms are those before the rollout's start.
        there = segments.valid[row, :, 0]
        inside = there & (at[row] > 0.06)
        due = np.interp(at[row] - 0.05, at[row], same[row, :, 0])
        # Lines between readings 10 ms apart: (0.01)^2 / 8 of an acceleration of at most 20.
        assert np.abs(read[row, inside, 0] - due[inside]).max() < 3e-4
        # What was read before goes on backwards as the parabola through the first 60 ms does: over
        # 0.11 s that is (0.11)^3 / 6 of 0.5 (4.4)^3 rad/s3. It does not stay at the start: 0.1 rad.
        parabola = np.polyfit(at[row, inside][:6], read[row, inside, 0][:6], 2)
        before = there & (at[row] < 0.05)
        assert read[row, before, 0] == pytest.approx(
            np.polyval(parabola, at[row, before]), abs=0.01
        )


def test_rollouts_of_a_late_sensor_start_at_the_truth(
    pendulum: Robot, recorded: Callable[..., Recording]
) -> None:
    run = recorded(pendulum, seconds=4.0, start={"hinge": 1.0}, noise=0.0)
    channels, late = dict(run.channels), TimestampOffset(channel="hinge.position", T=0.02)
    angle = channels["hinge.position"]
    channels["hinge.position"] = replace(angle, time=angle.time + 0.02)
    run, errors = replace(run, channels=channels), []
    step = step_for([run], pendulum)
    for effects in ((), (late,)):
        segments = cut([episode(run, pendulum, step)], 1.0, skip=0.2)
        model = Hypothesis(robot=pendulum, step=step, knobs=(), effects=effects)
        (read,) = predict(model, segments, [model.start], [segments.start])
        errors.append(float(np.sqrt(np.mean((segments.reading - read)[segments.valid] ** 2))))
    # Free motion is the same 20 ms later, so that it does not show at all: what is left are errors
    # of smoothed starts. With a rate of the wrong time they were 0.02 of 10 rad/s2 over 1 s: 0.1.
    assert errors[0] < 5e-3
    assert errors[1] < 5e-3


@pytest.mark.parametrize(("force", "decides", "explained"), [
    (0.02, True, True), (0.05, True, False), (0.2, False, False),
])  # fmt: skip
def test_evidence_decides_a_little_above_the_noise(
    force: float, decides: bool, explained: bool
) -> None:
    disturbance = SimpleNamespace(scale=np.array([force]), vibration=np.zeros(1))
    about = SimpleNamespace(disturbance=disturbance, inertial=np.ones(1), sensed=np.ones(1))
    runs: Any = [SimpleNamespace(about=about)]
    assert (evidence_decides(runs), at_noise(runs)) == (decides, explained)


def test_evidence_decides_on_a_push_beside_vibration() -> None:
    # Of forty stretches it acts in one: their mean gain is at most a fortieth of its own.
    disturbance = SimpleNamespace(scale=np.array([0.05]), vibration=np.full(1, 2.0))
    about = SimpleNamespace(disturbance=disturbance, inertial=np.ones(1), sensed=np.ones(1))
    runs: Any = [SimpleNamespace(about=about)]
    assert certain(16.0, runs, event=True)
    assert not certain(8.0, runs, event=True)
    assert not certain(1e3, runs)
    disturbance.vibration[:], disturbance.scale[:] = 0.0, 0.2
    assert not certain(1e3, runs, event=True)
