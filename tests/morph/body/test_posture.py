"""Poses in which loops are closed and followers follow."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from morph.body.four_bar import FourBar
from morph.body.load import load
from morph.body.posture import Posture
from morph.body.robot import Robot
from morph.body.spec import spec_of

BAR = FourBar(ground=0.16, crank=0.06, coupler=math.hypot(0.1, 0.1), rocker=0.1, branch=1)


def posture_of(robot: Robot) -> Posture:
    return Posture(spec_of(robot).compile())


def test_a_follower_has_no_handle_and_goes_as_its_law_says(gripper: Robot) -> None:
    posture = posture_of(gripper)
    assert [handle.joint for handle in posture.handles] == ["left", "rail"]
    pose, arrived = posture.towards(posture.rest, np.array([0.3, 0.0]))
    right = pose[posture.model.joint("right").qposadr[0]]
    # 0.1 - 2 * 0.3 = -0.5, closed to a millionth of a rad.
    assert arrived
    assert right == pytest.approx(-0.5, abs=1e-6)


def test_a_body_that_floats_is_left_where_it_is(gripper: Robot) -> None:
    posture = posture_of(gripper)
    pose, _ = posture.towards(posture.rest, np.array([-0.8, 0.01]))
    assert (pose[:7] == posture.model.qpos0[:7]).all()


def test_what_goes_beyond_a_range_stops_at_its_end(gripper: Robot) -> None:
    posture = posture_of(gripper)
    pose, _ = posture.towards(posture.rest, np.array([9.0, math.nan]))
    assert pose[posture.places[0]] == 1.0
    assert pose[posture.places[1]] == 0.0


def test_a_hinge_without_limits_goes_half_a_turn_either_way(arm: Callable[..., Robot]) -> None:
    for handle in posture_of(arm()).handles:
        assert (handle.low, handle.high, handle.limited) == (-math.pi, math.pi, False)
        assert handle.ranged


def test_a_slide_without_limits_has_no_range_of_its_own(gripper: Robot) -> None:
    rail = posture_of(gripper).handles[1]
    assert rail.kind == "slide"
    assert not rail.ranged
    assert rail.low < 0.0 < rail.high


@pytest.mark.parametrize("turned", [-0.4, 0.3, 0.9, 2.5])
def test_a_driven_four_bar_goes_as_its_closed_form(
    four_bar: Callable[..., Robot], turned: float
) -> None:
    posture = posture_of(four_bar())
    assert [handle.joint for handle in posture.handles] == ["drive"]
    pose, arrived = posture.towards(posture.rest, np.array([turned]))
    # About +y a positive turn goes from x towards -z, so that angles count downward: the crank
    # begins along the ground, and the rocker at 90 degrees above it.
    swung = float(pose[posture.model.joint("swing").qposadr[0]])
    expected = float(BAR.rocker_angle(0.0 - turned)) - float(BAR.rocker_angle(0.0))
    assert arrived
    # The loop is closed to 1e-9 m, on a rocker of 0.1 m: 1e-8 rad, and 100 times that near where
    # it is ill placed.
    assert -swung == pytest.approx(expected, abs=1e-6)


def test_a_loop_stops_where_what_follows_meets_its_limit(four_bar: Callable[..., Robot]) -> None:
    free = posture_of(four_bar())
    pose, _ = free.towards(free.rest, np.array([0.9]))
    swing = free.model.joint("swing").qposadr[0]
    most = 0.5 * float(pose[swing])
    low, high = sorted((0.0, most))
    kept = posture_of(four_bar(f'limited="true" range="{low - 1e-3} {high + 1e-3}"'))
    pose, arrived = kept.towards(kept.rest, np.array([0.9]))
    assert not arrived
    assert low - 2e-3 <= pose[swing] <= high + 2e-3
    # It went as far as it could: within a stride of the limit. The rocker turns at most about
    # as fast as the crank here, and the shortest stride is 1e-3 rad.
    assert abs(pose[swing] - most) < 5e-3


def test_every_pose_of_a_four_bar_quadruped_is_closed() -> None:
    robot = load("quadruped_four_bar")
    posture = posture_of(robot)
    rng = np.random.default_rng(3)
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    for _ in range(5):
        goal = [rng.uniform(handle.low, handle.high) for handle in posture.handles]
        data.qpos[:], _ = posture.towards(posture.rest, np.array(goal))
        # MuJoCo's own measure of the pins, after a whole forward pass.
        mujoco.mj_forward(model, data)
        assert np.abs(data.efc_pos[: data.ne]).max() < 2e-6


def test_movements_keep_the_loop_closed(four_bar: Callable[..., Robot]) -> None:
    posture = posture_of(four_bar())
    start, _ = posture.towards(posture.rest, np.array([0.6]))
    ahead, _ = posture.towards(posture.rest, np.array([0.6 + 1e-5]))
    posture.data.qpos[:] = start
    mujoco.mj_kinematics(posture.model, posture.data)
    mujoco.mj_comPos(posture.model, posture.data)
    slopes = posture.slopes()[:, 0]
    # The difference quotient over 1e-5 rad is off by the curvature, about 1e-5.
    assert slopes == pytest.approx((ahead - start) / 1e-5, abs=1e-3)


def test_loops_that_do_not_close_at_rest_leave_every_joint_free(
    body: Callable[[str], Robot],
) -> None:
    rod = (
        '<body name="{0}" pos="{1} 0 0"><joint name="{0}" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 0.1" size="0.01" mass="1"/></body>'
    )
    robot = body(
        "<mujoco><worldbody>"
        + rod.format("one", 0)
        + rod.format("two", 5)
        + '</worldbody><equality><connect body1="one" site1="" body2="two" anchor="0 0 0.1"/>'
        "</equality></mujoco>".replace(' site1=""', "")
    )
    model = spec_of(robot).compile()
    # MuJoCo takes the other end from where bodies are at home, so that it is moved here.
    model.eq_data[0, 3:6] += 3.0
    posture = Posture(model)
    assert not posture.sound
    assert [handle.joint for handle in posture.handles] == ["one", "two"]
