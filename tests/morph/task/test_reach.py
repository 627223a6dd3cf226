"""Reach: which points an arm can come to, and in which posture."""

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import TaskError
from morph.search.family.families import family_of
from morph.search.family.posture_policies import hold as hold_near
from morph.search.generations.population import tried
from morph.task.arm import Arm
from morph.task.hold import hold
from morph.task.reach import reach

ARM = """
<mujoco model="planar"><option gravity="0 0 -9.81"/>
  <worldbody>
    <body name="upper" pos="0 0 1"><joint name="shoulder" axis="0 -1 0" range="-170 170"/>
      <inertial pos="0.25 0 0" mass="2" diaginertia="0.1 0.1 0.1"/>
      <body name="lower" pos="0.5 0 0"><joint name="elbow" axis="0 -1 0" range="-170 170"/>
        <inertial pos="0.2 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
        <site name="tip" pos="0.4 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator><position name="shoulder" joint="shoulder" kp="100"/>
    <position name="elbow" joint="elbow" kp="100"/></actuator>
</mujoco>"""


@pytest.fixture
def planar(tmp_path: Path) -> Robot:
    """Return an arm of 0.5 m and 0.4 m in a plane, its shoulder at 1 m."""
    path = tmp_path / "planar.xml"
    path.write_text(ARM)
    return load(path)


def test_inverse_kinematics_finds_the_triangle_of_two_links(planar: Robot) -> None:
    arm = Arm(planar)
    point = np.array([0.5, 0.0, 1.3])
    posture, short = arm.posture(point)
    assert short < 1e-5
    # The law of cosines: d^2 = 0.5^2 + 0.4^2 + 2 * 0.5 * 0.4 cos elbow, d^2 = 0.34.
    assert abs(math.cos(posture[1]) - (0.34 - 0.41) / 0.4) < 1e-4
    assert arm.end(posture) == pytest.approx(point, abs=1e-5)


def test_what_holds_an_arm_out_is_its_weight_times_its_levers(planar: Robot) -> None:
    effort = Arm(planar).holding(np.zeros(2))
    # Level: the elbow holds 1 kg at 0.2 m, the shoulder also 1 kg at 0.5 m and 2 kg at 0.25 m.
    assert effort == pytest.approx([9.81 * (0.2 + 0.5 + 0.5), 9.81 * 0.2], rel=1e-9)


def test_a_point_beyond_the_arm_is_refused_with_how_near_it_comes(planar: Robot) -> None:
    # Stretched it comes to 0.9 m from its shoulder, and is asked for 2 m.
    with pytest.raises(TaskError, match=r"comes no nearer to \(2, 0, 1\) m than 1.1 m"):
        reach(planar, (2.0, 0.0, 1.0))


def test_a_body_that_is_not_held_has_nothing_to_reach_from() -> None:
    with pytest.raises(TaskError, match="not held to the world"):
        reach(load("sea_snake"))


def test_the_end_of_an_arm_is_its_tip() -> None:
    robot = load("so101")
    arm = Arm(robot)
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(arm.end(np.zeros(6)), data.site("tip").xpos, atol=1e-12)


def test_the_point_that_is_asked_for_by_default_is_far_and_above_the_table() -> None:
    robot = load("so101")
    target = np.array(reach(robot).goals[0].target)
    assert np.linalg.norm(target - Arm(robot).end(np.zeros(6))) > 0.2
    assert target[2] > 0.1


def test_servos_that_are_told_their_posture_sag_and_told_what_they_carry_they_hold() -> None:
    task = hold(load("so101"), {"Pitch": 1.0, "Elbow": -0.5})
    family = family_of(task)
    naive = hold_near(task.robot, task.start.position, period=task.period)
    policies = [family.policy(family.start), naive.policy(naive.start)]
    score = tried(task, policies, task.simulator(), runs=2, rng=np.random.default_rng(0))
    # 0.79 N m at the shoulder (0.45 kg at some 0.18 m) bend a servo of 17.8 N m/rad by 0.044 rad.
    assert score.success.all(axis=1).tolist() == [True, False]


def test_a_posture_beyond_a_joint_is_refused() -> None:
    with pytest.raises(TaskError, match=r"'Pitch' is to stay at 3 rad, and its range is -1.75"):
        hold(load("so101"), {"Pitch": 3.0})
