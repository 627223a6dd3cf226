"""Descriptions against recordings of which is known by what they part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.robot import Robot
from morph.errors import DiagnosisError, RecordingError
from morph.model.comparison import compare
from morph.physics.joint.coulomb_friction import CoulombFriction
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

NOISE = 2e-4


def swung(
    robot: Robot, *effects: CoulombFriction, seconds: float = 10.0, **more: float
) -> Recording:
    """Return a swing that a motor keeps up, as an encoder of known noise reads it."""
    push = more.get("push", 0.0)

    def told(times: np.ndarray) -> np.ndarray:
        return 0.5 * np.sin(7.0 * times)

    def pushed(times: np.ndarray) -> np.ndarray:
        return told(times) + push * ((times > 6.2) & (times < 6.4))

    run = Simulator(robot, effects).run(
        seconds=seconds, start={"hinge": 0.6}, command={"hinge": pushed}
    )
    position, command = run.channel("hinge.position"), run.channel("hinge.command")
    noise = np.random.default_rng(0).normal(0.0, NOISE, len(position.value))
    channels = {
        "hinge.position": replace(position, value=position.value + noise),
        "hinge.command": replace(command, value=told(command.time)),
    }
    return Recording(name="swing", channels=channels)


def test_nothing_parts_where_nothing_is_missing(pendulum: Robot) -> None:
    found = compare(pendulum, [swung(pendulum)])
    (hinge,) = found.channels
    # Smoothing lets 15 Hz of the noise through, and rounds motion of 1 Hz by its square over 15 Hz.
    assert not hinge.parts
    assert hinge.error < 0.005 * hinge.motion
    assert hinge.noise == pytest.approx(NOISE, rel=0.2)
    assert found.notes == ()
    # Rollouts of a second from 0.15 s on: nine end within 10 s.
    assert found.rollouts == 9


def balanced(seed: int = 0) -> Recording:
    """Return a pendulum that a controller holds upright, by its own equation."""
    inertia, weight, step = 0.251, 9.81 * 0.5, 1e-3
    q, v, angles, told = np.pi + 0.05, 0.0, [], []
    for at in range(10_000):
        if at % 10 == 0:
            push = -40.0 * (q - np.pi - 0.3 * np.sin(0.002 * at)) - 4.0 * v
        angles.append(q)
        told.append(push)
        v += step * (push - weight * np.sin(q)) / inertia
        q += step * v
    rng, time = np.random.default_rng(seed), step * np.arange(0, 10_000, 10)
    read = np.array(angles[::10]) + rng.normal(0.0, NOISE, len(time))
    channels = {
        "hinge.position": Channel(time=time, value=read),
        # A semi-implicit step has its force half a step before its time.
        "hinge.command": Channel(time=time - 0.5 * step, value=np.array(told[::10]), hold=True),
    }
    return Recording(name="balanced", channels=channels)


def test_a_right_description_does_not_part_where_errors_of_starts_grow(pendulum: Robot) -> None:
    (upright,) = compare(pendulum, [balanced()]).channels
    (hanging,) = compare(pendulum, [swung(pendulum)]).channels
    # Upright errors grow by exp(t sqrt(4.9 / 0.25)), 80 times in a second, from .2 mrad and of a
    # velocity of which 15 Hz of the noise pass.
    assert upright.error > 20.0 * upright.noise
    assert not upright.parts
    assert upright.by_starts > 20.0 * upright.noise
    assert hanging.by_starts < 5.0 * hanging.noise


def test_what_a_joint_lacks_is_the_size_of_its_hidden_friction(pendulum: Robot) -> None:
    rubbing = CoulombFriction(joint="hinge", c=0.2)
    (hinge,) = compare(pendulum, [swung(pendulum, rubbing)]).channels
    assert hinge.parts
    # A square wave of 0.2 N m, of which smoothing rounds the edges: about two a second.
    assert hinge.missing == pytest.approx(0.2, rel=0.15)


def test_the_worst_moment_is_that_of_a_push(pendulum: Robot) -> None:
    (hinge,) = compare(pendulum, [swung(pendulum, push=1.0)]).channels
    assert hinge.worst.recording == "swing"
    assert hinge.worst.start < 6.4
    assert hinge.worst.end > 6.2
    assert hinge.worst.error > 2.0 * hinge.error


def test_a_recording_shorter_than_a_rollout_is_simulated_whole(pendulum: Robot) -> None:
    found = compare(pendulum, [swung(pendulum, seconds=0.8)])
    assert found.horizon is None
    assert found.rollouts == 1


def test_an_actuator_without_a_command_is_told_zero_and_that_is_said(pendulum: Robot) -> None:
    run = swung(pendulum)
    alone = replace(run, channels={"hinge.position": run.channel("hinge.position")})
    found = compare(pendulum, [alone])
    assert found.channels[0].parts
    # 0.5 sin has an RMS of 0.354.
    assert found.channels[0].missing == pytest.approx(0.354, rel=0.1)
    assert found.notes == (
        "recording swing: no command was recorded of hinge: the simulation is told 0",
    )


def test_a_joint_that_was_not_measured_is_refused_by_name(pendulum: Robot) -> None:
    run = swung(pendulum)
    blind = replace(run, channels={"hinge.command": run.channel("hinge.command")})
    with pytest.raises(RecordingError, match=r"hinge\.position"):
        compare(pendulum, [blind])


def test_nothing_is_compared_with_readings_that_no_robot_gives(pendulum: Robot) -> None:
    run = swung(pendulum)
    wild = Channel(time=run.channel("hinge.position").time, value=1e6 * run["hinge.position"])
    with pytest.raises(RecordingError, match=r"hinge\.position"):
        compare(pendulum, [replace(run, channels={**run.channels, "hinge.position": wild})])


def test_a_recording_too_short_for_a_rollout_is_left_out_and_said(pendulum: Robot) -> None:
    brief = replace(swung(pendulum, seconds=0.8), name="brief")
    found = compare(pendulum, [swung(pendulum), brief])
    assert found.horizon == 1.0
    assert found.notes == ("recording brief: too short for a rollout, left out",)


@pytest.mark.parametrize("names", [(), ("swing", "swing")])
def test_no_recording_and_two_of_one_name_are_refused(
    pendulum: Robot, names: tuple[str, ...]
) -> None:
    given = [replace(swung(pendulum, seconds=2.0), name=name) for name in names]
    with pytest.raises(DiagnosisError):
        compare(pendulum, given)
