"""Compiled laws with a memory against their steps in simulations, and friction's sense at rest."""

from __future__ import annotations

import numpy as np
import pytest

from morph.physics.joint.backlash import LIGHT, Motors, _Rotor
from morph.physics.joint.hysteresis import followed
from morph.physics.joint.recorded import followed_backlash, followed_hysteresis
from morph.physics.motion import Motion


def test_hysteresis_follows_as_in_a_simulation() -> None:
    rng = np.random.default_rng(0)
    place = np.cumsum(0.02 * rng.normal(size=500))
    place[200:220] = place[200]
    z = np.array([0.01, 0.1, 3.0])
    held, due = np.zeros(3), [np.zeros(3)]
    for move in np.diff(place):
        held = followed(held, move / z)
        due.append(held)
    assert followed_hysteresis(place, z) == pytest.approx(np.array(due), abs=1e-12)


@pytest.mark.parametrize("motors", [(0.0, 0.0), (30.0, 0.4)])
@pytest.mark.parametrize("inertia", [0.0, 0.02])
def test_a_rotor_in_its_play_steps_as_in_a_simulation(
    motors: tuple[float, float], inertia: float
) -> None:
    rng = np.random.default_rng(1)
    time = 0.002 * np.arange(600)
    effort = np.sin(9.0 * time) + 0.3 * rng.normal(size=600)
    speed = np.cos(7.0 * time)
    slope = np.gradient(speed, 0.002)
    late = speed - 0.001 * slope
    step = np.full(600, 0.002)
    gap = np.array([0.0, 0.003, 0.05])
    rotor = _Rotor.at_end(effort[0] * np.ones(3), gap, late[0] * np.ones(3))
    due = np.empty((600, 3))
    for t in range(600):
        lead = np.where(rotor.side != 0.0, 0.0, rotor.rate - speed[t])
        push = Motors(
            torque=effort[t] - motors[0] * rotor.ahead - motors[1] * lead,
            stiffness=np.full(3, motors[0]),
            damping=np.full(3, motors[1]),
        )
        past = slope[t - 1] if t else 0.0
        felt, loose, rotor = rotor.step(push, np.full(3, inertia), late[t], past, 0.002)
        due[t] = felt - effort[t] + np.where(loose, inertia * slope[t], 0.0)
    found = followed_backlash(
        effort, late, speed, slope, step, motors=motors, inertia=(inertia, LIGHT), gap=gap
    )
    assert found[:, 1:] == pytest.approx(due[:, 1:], rel=1e-9, abs=1e-9)


def test_friction_turns_over_a_ten_thousandth_of_the_range_and_holds_at_rest() -> None:
    # Up by 1, rest, down by 2e-4 in steps of 2e-5: 1e-4 of the range turn it from 1 to 0.
    place = np.concatenate([np.linspace(0.0, 1.0, 11), np.ones(5), 1.0 - 2e-5 * np.arange(1, 11)])
    none = np.zeros((len(place), 1))
    motion = Motion(
        position=place[:, None],
        velocity=none,
        acceleration=none,
        drive=np.zeros((len(place), 0, 1)),
        drive_rate=np.zeros((len(place), 0, 1)),
        stiffness=np.zeros((len(place), 1, 1)),
        joints={"hinge": 0},
        actuators={},
    )
    sign = motion.sign("hinge")
    assert sign[:16].tolist() == [0.0] + [1.0] * 15
    assert sign[16:] == pytest.approx(np.maximum(1.0 - 0.2 * np.arange(1, 11), -1.0), abs=1e-6)
