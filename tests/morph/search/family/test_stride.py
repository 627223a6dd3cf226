"""Strides: springs whose set points swing, as far as joints go."""

import numpy as np
import pytest

from morph.body.load import load
from morph.body.postures import posture_of
from morph.search.family.stride import WIDEST, stride


def test_a_stride_is_a_spring_about_a_set_point_that_swings() -> None:
    robot = load("hopper")
    place = posture_of(robot)
    family = stride(robot, place, seconds=2.0, period=0.002)
    values = {number.name: number.start for number in family.numbers}
    values |= {"stiffness": 0.5, "damping": -2.0, "frequency": 1.0}
    made = family.make(np.array([values[number.name] for number in family.numbers]))
    # On the set point, and as fast as it is told to be (not at all), nothing is asked for.
    at = 250
    on = made.nominal[at]
    assert made.act(on, np.array(0.5)) == pytest.approx([0.0, 0.0, 0.0])
    off = on.copy()
    off[0] += 0.01
    off[3] += 0.1
    # Weaker than its motors of 200 N m: its weight at the end of its reach.
    k = 10.0**0.5 * family.strength[0]
    assert 100.0 < family.strength[0] < 200.0
    assert made.act(off, np.array(0.5))[0] == pytest.approx(-k * 0.01 - 0.01 * k * 0.1)
    # The hip is back where it was after a whole second, and not after a quarter.
    hip = made.nominal[:, 0]
    assert hip[at + 500] == pytest.approx(hip[at])
    assert abs(hip[at + 125] - hip[at]) > 0.01


def test_set_points_stay_within_the_ranges_of_their_joints() -> None:
    robot = load("biped")
    place = posture_of(robot)
    family = stride(robot, place, seconds=2.0, period=0.01)
    rng = np.random.default_rng(0)
    for point in rng.uniform(size=(10, len(family.numbers))):
        nominal = family.make(family.values(point)).nominal[:, :6]
        for column, actuator in zip(nominal.T, robot.actuators, strict=True):
            low, high = robot.joint(actuator.joint).limits or (-9.0, 9.0)
            assert (column >= max(low, place[actuator.joint] - WIDEST) - 1e-9).all()
            assert (column <= min(high, place[actuator.joint] + WIDEST) + 1e-9).all()
