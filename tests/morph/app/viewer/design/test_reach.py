"""How far a body gets."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from morph.app.picture.shapes import shapes
from morph.app.viewer.design.reach import Reach, corners
from morph.body.load import load
from morph.body.poses import drawn
from morph.body.posture import Posture
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.vary import Scale, vary


def reach_of(robot: Robot) -> float:
    model = spec_of(robot).compile()
    posture = Posture(model)
    return Reach(posture, tuple(shapes(model))).most(drawn(posture))


TIP = 0.001
"""Radius of the round ends of the arm, m."""


ROUND = 0.05 * TIP
"""A ball in triangles of 18 degrees lacks 1 - cos 18 degrees = 4.9 % of its radius."""


def test_an_arm_of_two_links_reaches_as_far_as_both_are_long(arm: Callable[..., Robot]) -> None:
    assert reach_of(arm()) == pytest.approx(0.4 + 0.3 + TIP, abs=ROUND)


def test_an_elbow_that_stretches_within_its_limits_costs_nothing(arm: Callable[..., Robot]) -> None:
    # Straight where it stands at 1.5 rad, which is within its limits.
    free = arm(elbow='limited="true" range="1 2" ref="1.5"')
    assert reach_of(free) == pytest.approx(0.7 + TIP, abs=ROUND)


def test_a_pose_at_rest_counts_even_beyond_the_limits(arm: Callable[..., Robot]) -> None:
    bent = arm(elbow='limited="true" range="0.8 2"')
    assert reach_of(bent) == pytest.approx(0.7 + TIP, abs=ROUND)


def test_a_fixed_elbow_reaches_less_by_the_law_of_cosines(body: Callable[[str], Robot]) -> None:
    robot = body(
        '<mujoco><worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.001" mass="1"/>'
        '<body name="end" pos="0.4 0 0" euler="0 60 0">'
        '<geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.001" mass="1"/>'
        "</body></body></worldbody></mujoco>"
    )
    # Bent by 60 degrees: sqrt(0.4^2 + 0.3^2 + 2 * 0.4 * 0.3 * cos 60) = 0.608276 m.
    expected = math.sqrt(0.16 + 0.09 + 0.12)
    assert reach_of(robot) == pytest.approx(expected, abs=1.1 * TIP)


def test_a_slide_reaches_from_where_it_is_held_to_its_end(body: Callable[[str], Robot]) -> None:
    robot = body(
        '<mujoco><worldbody><body name="base"><geom size="0.01" mass="1"/>'
        '<body name="rod" pos="0.1 0 0"><joint name="slide" type="slide" axis="1 0 0"'
        ' limited="true" range="-0.5 0.2"/><geom size="0.01" mass="1"/></body>'
        "</body></worldbody></mujoco>"
    )
    # 0.1 - 0.5 - 0.01: farther back than forward.
    assert reach_of(robot) == pytest.approx(0.41, abs=1e-4)


def test_a_body_twice_as_large_reaches_twice_as_far() -> None:
    robot = load("so101")
    # The same poses are drawn, so that the same pose is the best; meshes are of single precision.
    assert reach_of(vary(robot, Scale(link="*", factor=2.0))) == pytest.approx(
        2.0 * reach_of(robot), rel=1e-5
    )


def test_the_best_pose_is_at_least_as_good_as_a_thousand_others() -> None:
    robot = load("so101")
    model = spec_of(robot).compile()
    posture, found = Posture(model), tuple(shapes(model))
    reach = Reach(posture, found)
    rng = np.random.default_rng(11)
    low = np.array([handle.low for handle in posture.handles])
    high = np.array([handle.high for handle in posture.handles])
    others = [posture.towards(posture.rest, rng.uniform(low, high))[0] for _ in range(1000)]
    data = posture.data
    best = 0.0
    for pose in others:
        data.qpos[:] = pose
        mujoco.mj_kinematics(posture.model, data)
        best = max(best, reach.at(data)[0])
    assert reach.most(drawn(posture)) >= best


def test_points_inside_others_are_left_out() -> None:
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    inner = np.full((5, 3), 0.5)
    kept = corners(np.concatenate((cube, inner)))
    assert sorted(map(tuple, kept)) == sorted(map(tuple, cube))


def test_flat_points_are_all_kept() -> None:
    flat = np.array([[x, y, 0.0] for x in range(3) for y in range(3)], dtype=float)
    assert len(corners(flat)) == 9
