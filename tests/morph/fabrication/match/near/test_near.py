"""Policies near a policy."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.fabrication.match.near.near import near
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.pattern import Pattern, Swing, pattern
from morph.policy.policy import Policy, actions_of
from morph.policy.track import Track

TIMES = np.linspace(0.0, 2.0, 41)


def trot() -> Pattern:
    robot = load("quadruped_printed")
    swings = {
        each.name: Swing(offset=0.1, amplitude=0.2, frequency=1.5, phase=0.3 * at)
        for at, each in enumerate(robot.actuators)
    }
    return pattern(robot, swings, period=0.05)


def law() -> Linear:
    robot = load("cartpole")
    seen = observations_of(robot)
    weight = np.array([[1.0, 20.0, 2.0, 3.0]])
    return Linear(
        weight=weight, bias=np.array([0.5]), action=actions_of(robot), observation=seen, period=0.05
    )


def track() -> Track:
    robot = load("cartpole")
    seen, rng = observations_of(robot), np.random.default_rng(0)
    return Track(
        nominal=rng.normal(size=(9, 4)),
        command=rng.normal(size=(9, 1)),
        gain=rng.normal(size=(9, 1, 4)),
        action=actions_of(robot),
        observation=seen,
        period=0.05,
    )


CASES = pytest.mark.parametrize(
    ("policy", "body"),
    [(trot(), "quadruped_printed"), (law(), "cartpole"), (track(), "cartpole")],
    ids=["pattern", "linear", "track"],
)


@CASES
def test_the_middle_of_the_cube_is_the_policy_itself(policy: Policy, body: str) -> None:
    family = near(policy, load(body), 0.1)
    assert family is not None
    assert (family.start == 0.5).all()
    seen = policy.typical(TIMES, np.random.default_rng(1))
    # 1 + 0 and a sum with 0 are exact; the clipped command is clipped once more.
    assert family.policy(family.start).act(seen, TIMES) == pytest.approx(
        policy.act(seen, TIMES), abs=1e-12
    )


@CASES
def test_every_number_changes_what_is_commanded(policy: Policy, body: str) -> None:
    family = near(policy, load(body), 0.1)
    assert family is not None
    seen = policy.typical(TIMES, np.random.default_rng(1)) * 0.1
    before = family.policy(family.start).act(seen, TIMES)
    for at in range(len(family.numbers)):
        point = family.start.copy()
        point[at] += 0.05
        moved = np.abs(family.policy(point).act(seen, TIMES) - before).max()
        assert moved > 1e-6, family.numbers[at].name


def test_legs_that_are_alike_stay_alike() -> None:
    family = near(trot(), load("quadruped_printed"), 0.1)
    assert family is not None
    rng = np.random.default_rng(2)
    found = family.policy(np.clip(family.start + 0.1 * rng.normal(size=len(family.numbers)), 0, 1))
    assert isinstance(found, Pattern)
    left, right = (
        next(at for at, each in enumerate(found.action) if each.actuator == name)
        for name in ("front_left_hip", "front_right_hip")
    )
    one, other = found.swings[left], found.swings[right]
    assert (one.amplitude, one.offset, one.frequency) == pytest.approx(
        (other.amplitude, other.offset, other.frequency)
    )
    # What they differed by before, 0.3 rad an actuator, they differ by still.
    assert other.phase - one.phase == pytest.approx(0.3 * (right - left))
