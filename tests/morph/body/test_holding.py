"""What motors hold."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from morph.body.holding import Holding, least, margins
from morph.body.load import load
from morph.body.posture import Posture
from morph.body.robot import Robot
from morph.body.spec import spec_of

GRAVITY = 9.81


def holding_of(robot: Robot) -> tuple[Holding, Posture]:
    posture = Posture(spec_of(robot).compile())
    return Holding(robot, posture), posture


@pytest.mark.parametrize(("shoulder", "elbow"), [(0.0, 0.0), (0.7, -0.4), (math.pi / 2, 1.0)])
def test_an_arm_holds_the_moments_of_its_weights(
    arm: Callable[..., Robot], shoulder: float, elbow: float
) -> None:
    holding, posture = holding_of(arm())
    pose, _ = posture.towards(posture.rest, np.array([shoulder, elbow]))
    # About +y gravity turns what lies along +x by +m g x: a motor holds it by the opposite.
    lower = 1.0 * GRAVITY * 0.1 * math.cos(shoulder + elbow)
    upper = (2.0 * 0.2 + 1.0 * 0.4) * GRAVITY * math.cos(shoulder) + lower
    assert holding.at(pose) == pytest.approx([-upper, -lower], abs=1e-9)


def test_a_spring_holds_what_the_motor_need_not(arm: Callable[..., Robot]) -> None:
    holding, posture = holding_of(arm(elbow='stiffness="3"'))
    pose, _ = posture.towards(posture.rest, np.array([0.0, 0.5]))
    # The spring pulls back by 3 * 0.5 N m, with the motor and against the weight.
    weight = 1.0 * GRAVITY * 0.1 * math.cos(0.5)
    assert holding.at(pose)[1] == pytest.approx(-weight + 1.5, abs=1e-9)


@pytest.mark.parametrize("turned", [-0.3, 0.2, 0.9])
def test_the_motor_of_a_loop_holds_the_slope_of_all_its_weights(
    four_bar: Callable[..., Robot], turned: float
) -> None:
    robot = four_bar()
    holding, posture = holding_of(robot)

    def energy(angle: float) -> float:
        pose, _ = posture.towards(posture.rest, np.array([angle]))
        data = mujoco.MjData(posture.model)
        data.qpos[:] = pose
        mujoco.mj_kinematics(posture.model, data)
        return float(posture.model.body_mass @ data.xipos[:, 2]) * GRAVITY

    pose, _ = posture.towards(posture.rest, np.array([turned]))
    slope = (energy(turned + 1e-4) - energy(turned - 1e-4)) / 2e-4
    # Central differences are off by h^2 / 6 of the third derivative, about 1e-8 N m; loops are
    # closed to 1e-9 m, which by m g / h is 1e-4 N m at worst.
    assert holding.at(pose)[0] == pytest.approx(slope, abs=2e-4)


def test_two_motors_on_one_joint_share_its_load(body: Callable[[str], Robot]) -> None:
    robot = body(
        '<mujoco><worldbody><body name="rod"><joint name="hinge" axis="0 1 0"/>'
        '<inertial pos="0.5 0 0" mass="1" diaginertia="0.1 0.1 0.1"/><geom size="0.01" mass="0"/>'
        "</body></worldbody><actuator>"
        '<motor name="one" joint="hinge"/><motor name="two" joint="hinge"/></actuator></mujoco>'
    )
    holding, posture = holding_of(robot)
    assert holding.at(posture.rest) == pytest.approx([-0.25 * GRAVITY] * 2, abs=1e-9)


def test_what_nobody_drives_is_held_by_nobody() -> None:
    holding, posture = holding_of(load("cartpole"))
    pose, _ = posture.towards(posture.rest, np.array([0.1, 0.7]))
    # The cart rolls on a level rail: its motor holds nothing, whatever the pole does.
    assert holding.at(pose) == pytest.approx([0.0], abs=1e-12)


def test_margins_are_what_is_left_of_limits() -> None:
    found = margins(np.array([1.0, -3.0, 2.0]), np.array([2.0, 2.0, np.nan]))
    assert found[:2].tolist() == [0.5, -0.5]
    assert math.isnan(found[2])
    assert least(np.array([1.0, -3.0, 2.0]), np.array([2.0, 2.0, np.nan])) == (-0.5, 1)
    assert least(np.array([1.0]), np.array([np.nan])) == (None, None)
