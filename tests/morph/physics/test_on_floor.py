"""A robot whose description has no floor, on the floor of a named world."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import spec_of
from morph.errors import EffectError
from morph.physics.worlds import on_floor
from morph.sim.simulator import Simulator


def test_what_fell_rests_on_the_floor() -> None:
    robot = load("quadruped_printed")
    (link,) = (joint.link for joint in robot.joints if joint.kind == "free")
    standing = on_floor(robot, "hard_floor")
    heights = [
        Simulator(each, step=0.001).run(seconds=1.0)[f"{link}.position.z"]
        for each in (robot, standing)
    ]
    # Without a floor: g t^2 / 2 of 1 s, and first order in the step of 1 ms.
    assert heights[0][0] - heights[0][-1] == pytest.approx(9.81 / 2.0, rel=2e-3)
    assert heights[1][-1] > 0.0
    assert np.ptp(heights[1][-100:]) < 1e-3
    # All else stays.
    assert np.array_equal(spec_of(standing).compile().body_mass, spec_of(robot).compile().body_mass)
    assert (standing.joints, standing.actuators) == (robot.joints, robot.actuators)


def test_a_floor_that_is_too_stiff_is_refused_with_one_that_is_not() -> None:
    robot = load("quadruped_four_bar")
    with pytest.raises(EffectError, match="rubber_on_wood is no floor") as caught:
        on_floor(robot, "rubber_on_wood")
    assert "name hard_floor" in caught.value.fix
    assert 'type="plane"' in on_floor(robot, "hard_floor").mjcf


def test_water_is_no_floor() -> None:
    with pytest.raises(EffectError, match="water is no floor") as caught:
        on_floor(load("pendulum"), "water")
    assert "`[water]`" in caught.value.fix
