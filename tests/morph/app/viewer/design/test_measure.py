"""Figures of a body over the poses that it can take."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from morph.app.viewer.design.measure import measured
from morph.app.viewer.figure import figure
from morph.body.load import load
from morph.body.posture import Posture
from morph.body.robot import Robot


def test_the_worst_pose_of_a_pendulum_is_level() -> None:
    robot = load("pendulum")
    drawn = figure(robot)
    found = measured(robot, Posture(drawn.model), drawn.shapes)
    # 1 kg at 0.5 m: at most 4.905 N m of 10. Of 200 angles drawn evenly the nearest to level is
    # off by about pi / 200 at most times 3, which costs 1 - cos 0.05 = 0.12 %.
    assert found.efforts[0] == pytest.approx(4.905, rel=2e-3)
    assert found.margin == pytest.approx(1.0 - 4.905 / 10.0, abs=2e-3)
    assert found.mass == pytest.approx(1.0, abs=1e-12)
    assert (found.joints, found.freedoms, found.poses) == (1, 1, 201)


def test_figures_count_what_loops_leave(four_bar: Callable[..., Robot]) -> None:
    robot = four_bar()
    drawn = figure(robot)
    found = measured(robot, Posture(drawn.model), drawn.shapes)
    # Three hinges, and a planar pin takes two.
    assert (found.joints, found.freedoms) == (1, 1)
    # At rest: the crank's tip to the coupler's, 0.002 m of radius on either side.
    assert found.size == pytest.approx((0.164, 0.004, 0.104), abs=1e-4)
