"""Following a course: where postures come from, and that an arm of servos follows them."""

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import SearchError
from morph.policy.policy import Policy
from morph.search.family.families import family_of
from morph.search.family.follow import follow
from morph.search.family.posture_policies import hold
from morph.search.generations.population import tried
from morph.task.arm import Arm
from morph.task.track import Course, track


def test_the_postures_of_a_course_put_the_end_on_it() -> None:
    robot = load("so101")
    task = track(robot)
    course = task.goals[0].quantity
    assert isinstance(course, Course)
    family = follow(robot, course, seconds=1.0, period=0.02)
    arm = Arm(robot)
    ends = np.array([arm.end(each) for each in family.postures])
    time = 0.02 * np.arange(len(ends))
    np.testing.assert_allclose(ends, course.at(time), atol=1e-5)


def test_a_course_goes_round_its_circle_and_on() -> None:
    course = Course(
        link="gripper", begin=(1.0, 2.0, 3.0), velocity=(0.5, 0.0, 0.0), radius=0.1, turn=4.0
    )
    # After half a round it is two radii towards -y, after a whole one where it began, but for x.
    expected = [[1.0, 2.0, 3.0], [2.0, 1.8, 3.0], [3.0, 2.0, 3.0]]
    np.testing.assert_allclose(course.at(np.array([0.0, 2.0, 4.0])), expected, atol=1e-12)


def test_an_arm_told_ahead_of_time_follows_and_one_that_rests_does_not() -> None:
    task = track(load("so101"))
    family = family_of(task)
    policies = [family.policy(family.start), resting(task.robot.name)]
    score = tried(task, policies, task.simulator(), runs=3, rng=np.random.default_rng(2))
    assert score.success.tolist() == [[True] * 3, [False] * 3]


def resting(body: str) -> Policy:

    family = hold(load(body), {})
    return family.policy(family.start)


def test_motors_are_refused_by_name() -> None:
    robot = load("double_pendulum")
    course = Course(link="lower", begin=(0.0, 0.0, 0.0))
    with pytest.raises(SearchError, match="are motors"):
        follow(robot, course, seconds=1.0, period=0.02)
