"""The model that runs are linearised by knows how stiff effects are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.inference.disturbance import log_likelihood
from morph.inference.observed import observed
from morph.model.episodes import Episode, episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.joint.end_stop import EndStop
from morph.physics.sensor.sensor_scale import SensorScale
from morph.physics.sensor.timestamp_offset import TimestampOffset
from morph.record.recording import Recording


def laid(run: Recording, robot: Robot) -> tuple[Episode, Any]:
    """Return a recording on the grid of a simulation, and the description's model."""
    step = step_for([run], robot)
    nominal = Hypothesis(robot=robot, step=step, knobs=())
    return episode(run, robot, step), nominal.at(nominal.start).model


def test_a_stop_is_as_stiff_in_the_linearised_model(
    pendulum: Robot, recorded: Callable[..., Recording]
) -> None:
    run = recorded(pendulum, seconds=4.0, seed=0, name="run", start={"hinge": 0.5})
    read, model = laid(run, pendulum)
    k, d, edge = 5.0, 0.3, 0.1
    stop = EndStop(joint="hinge", q_stop=edge, k=k, d=d)
    first = observed(model, pendulum, read)
    about = observed(model, pendulum, read, effects=[stop], before=first).about
    # The slope is that along the motion before.
    place, speed = first.motion.position[:, 0], first.motion.velocity[:, 0]
    inside = (place > edge + 1e-6) & (k * (place - edge) + d * speed > 1e-6)
    outside = place < edge - 1e-6
    assert min(inside.sum(), outside.sum()) > 100
    mobility, local = about.mobility[:, 0, 0], about.local[:, 0]
    # By the trapezoidal rule damping divides all by 1 - h / 2 times the slope of the acceleration.
    bare, stopped = (1.0 - 0.5 * read.step * (local[:, 1] - each * mobility) for each in (0.0, d))
    found = about.tangent.jacobian[:, 0, 0]
    # Central differences of a force that is linear err by rounding, 1e-16 / 1e-7.
    due = (local[:, 0] - k * mobility) / stopped
    assert found[inside] == pytest.approx(due[inside], rel=1e-6)
    assert found[outside] == pytest.approx((local[:, 0] / bare)[outside], rel=1e-9)
    assert np.isfinite(found).all()


def test_a_sensor_that_reads_half_loses_no_evidence(
    pendulum: Robot, recorded: Callable[..., Recording]
) -> None:
    run = recorded(pendulum, seconds=4.0, seed=0, name="run", start={"hinge": 0.5})
    read, model = laid(run, pendulum)
    # The smoothed motion is settled: one more round moves it by less than rounding matters.
    first = observed(model, pendulum, read)
    first = observed(model, pendulum, read, before=first)
    known = first.about.disturbance
    assert known.vibration is not None
    half = replace(known, noise=0.5 * known.noise, vibration=0.5 * known.vibration)
    before = replace(first, about=replace(first.about, disturbance=half))
    halved = replace(read, reading=0.5 * read.reading, noise=0.5 * read.noise)
    scale = SensorScale(channel="hinge.position", gain=0.5)
    found = observed(model, pendulum, halved, effects=[scale], before=before)
    assert found.about.tangent.reads == pytest.approx(np.array([[0.5, 0.0]]), abs=1e-6)
    whole, scaled = observed(model, pendulum, read, before=first).about, found.about
    # Readings half as large are twice as dense: ln 2 for each. A slope by differences of 1e-7
    # errs by 1e-9, of a square that is about one for each of the readings.
    gain = log_likelihood(scaled, scaled.disturbance) - log_likelihood(whole, whole.disturbance)
    assert gain == pytest.approx(whole.tangent.valid.sum() * np.log(2.0), abs=1e-3)


def test_a_late_reading_sees_the_velocity(
    pendulum: Robot, recorded: Callable[..., Recording]
) -> None:
    run = recorded(pendulum, seconds=4.0, seed=0, name="run", start={"hinge": 0.5})
    read, model = laid(run, pendulum)
    first = observed(model, pendulum, read)
    late = TimestampOffset(channel="hinge.position", T=0.003)
    about = observed(model, pendulum, read, effects=[late], before=first).about
    assert about.tangent.reads == pytest.approx(np.array([[1.0, -0.003]]), abs=1e-6)


def test_a_delay_makes_the_times_of_commands_no_better_known(
    pendulum: Robot, recorded: Callable[..., Recording]
) -> None:
    run = recorded(pendulum, seconds=4.0, seed=0, name="run", start={"hinge": 0.5})
    rng = np.random.default_rng(0)
    (motor,) = (actuator.name for actuator in pendulum.actuators)
    clock = run.channels[f"{motor}.command"]
    jitter = replace(clock, time=clock.time + rng.uniform(0.0, 0.001, len(clock.time)))
    run = replace(run, channels={**run.channels, f"{motor}.command": jitter})
    read, model = laid(run, pendulum)
    read = replace(read, command=np.repeat(rng.normal(size=(len(read.command) // 4, 1)), 4, axis=0))
    first = observed(model, pendulum, read)
    # Half a step late: each change of the command is spread over two samples.
    delay = ActuatorDelay(actuator=motor, T=0.5 * read.step)
    same, later = (
        observed(model, pendulum, read, effects=each, before=first).about.disturbance.jolt
        for each in ([], [delay])
    )
    assert same is not None
    assert later is not None
    # Commands change every four samples.
    assert np.flatnonzero(same[:, 0, 0]).tolist() == list(range(4, len(same), 4))
    # A hinge's inertia does not change: the jolts are those of the commands as sent.
    assert later == pytest.approx(same, rel=1e-9)
