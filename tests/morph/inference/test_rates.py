"""Sensors of velocity beside coarse encoders: a pendulum by its own equation, not by MuJoCo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.inference.diagnose import diagnose
from morph.inference.observed import observed
from morph.model.diagnosis import Diagnosis
from morph.model.episodes import episode
from morph.record.recording import Channel, Recording

TIME = 0.01 * np.arange(800)
COUNT, SENSOR = 2.0 * np.pi / 500, 0.01
"""Counts of the encoder, rad, and the standard deviation of the sensor of velocity, rad/s."""
VISCOUS, MUCH = 0.03, 0.5
"""N m s/rad."""
INERTIA, WEIGHT = 0.001 + 0.5**2, 9.81 * 0.5
"""About the hinge, kg m2, and N m, of `robots/pendulum`."""


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("pendulum")


def moved(seed: int, viscous: float) -> tuple[Array, Array, Array]:
    """Return commands, angles and rates of a pendulum that begins at rest."""
    rng = np.random.default_rng(seed)
    phase, size = rng.uniform(0.0, 6.0, 3), rng.uniform(0.5, 1.5, 3)
    pushes = [
        np.sin(rate * TIME + shift) for rate, shift in zip((2.0, 4.7, 7.1), phase, strict=True)
    ]
    command = size @ np.array(pushes)

    def rates(time: float, state: Array) -> list[float]:
        # The command is held until the next one.
        held = command[min(int(time / 0.01 + 1e-9), len(command) - 1)]
        pull = held - WEIGHT * np.sin(state[0]) - viscous * state[1]
        return [state[1], pull / INERTIA]

    state, path = np.zeros(2), []
    for now in TIME:
        path.append(state)
        state = solve_ivp(rates, (now, now + 0.01), state, rtol=1e-9, atol=1e-11).y[:, -1]
    return command, *np.array(path).T


def recorded(seed: int, viscous: float = 0.0, *, sensor: bool = True) -> Recording:
    """Return what an encoder that counts and a sensor of velocity read."""
    command, angle, rate = moved(seed, viscous)
    rng = np.random.default_rng(100 + seed)
    read = rate + SENSOR * rng.standard_normal(len(TIME))
    channels = {
        "hinge.position": Channel(time=TIME, value=np.round(angle / COUNT) * COUNT),
        "hinge.velocity": Channel(time=TIME, value=read),
        "hinge.command": Channel(time=TIME, value=command, hold=True),
    }
    if not sensor:
        del channels["hinge.velocity"]
    return Recording(name=f"run_{seed}", channels=channels)


def diagnosed(robot: Robot, viscous: float) -> Diagnosis:
    """Return the diagnosis of three runs, of which the last is held out.

    One of those that are fitted lacks the sensor of velocity.
    """
    runs = [recorded(seed, viscous, sensor=seed != 1) for seed in range(3)]
    return diagnose(robot, runs[:2], held_out=runs[2:])


def test_the_smoothed_velocity_is_nearer(robot: Robot) -> None:
    _, _, rate = moved(0, MUCH)
    model, errors = spec_of(robot).compile(), []
    for sensor in (False, True):
        run = recorded(0, MUCH, sensor=sensor)
        seen = observed(model, robot, episode(run, robot, 0.0025))
        time = seen.run.step * np.arange(len(seen.motion.velocity))
        errors.append(np.std(seen.motion.velocity[:, 0] - np.interp(time, TIME, rate)))
    # The model lacks a friction that takes its motion from it: readings alone tell the velocity.
    assert errors[1] < 0.5 * errors[0]
    assert errors[1] < SENSOR


def test_friction_is_found_beside_it(robot: Robot) -> None:
    found = diagnosed(robot, VISCOUS)
    assert [each.effect.label for each in found.findings] == ["viscous_friction@hinge"]
    (estimate,) = found.findings[0].parameters.values()
    # The interval of 90 %, and twice as wide.
    assert abs(estimate.value - VISCOUS) < estimate.high90 - estimate.low90 < 0.5 * VISCOUS
    assert "Sensors of velocity are read too: hinge.velocity." in found.notes


def test_a_sensor_invents_nothing(robot: Robot) -> None:
    found = diagnosed(robot, 0.0)
    assert (found.verdict, found.findings) == ("consistent", ())


def test_a_sensor_that_lags_accuses_nobody(robot: Robot) -> None:
    runs = []
    for seed in range(3):
        run = recorded(seed)
        late = replace(run.channels["hinge.velocity"], time=TIME + 0.03)
        runs.append(replace(run, channels={**run.channels, "hinge.velocity": late}))
    found = diagnose(robot, runs[:2], held_out=runs[2:])
    assert (found.verdict, found.findings) == ("consistent", ())
