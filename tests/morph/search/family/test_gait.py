"""Gaits: which patterns a few numbers make."""

import math

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import SearchError
from morph.search.family.family import Number
from morph.search.family.gait import gait


@pytest.mark.parametrize(
    ("body", "most"),
    [("quadruped_printed", 11), ("sea_snake", 10), ("hexapod_swimmer", 7)],
)
def test_a_gait_has_few_numbers(body: str, most: int) -> None:
    assert 4 <= len(gait(load(body)).numbers) <= most


def test_legs_of_one_role_swing_alike_but_for_their_lags() -> None:
    robot = load("quadruped_printed")
    family = gait(robot)
    told = {number.name: number.start for number in family.numbers}
    told |= {"lag of the right": 1.0, "hip lag": 0.5, "hip amplitude": 0.3, "hip slant": 0.1}
    made = family.make(np.array([told[number.name] for number in family.numbers]))
    swing = dict(zip((a.actuator for a in made.action), made.swings, strict=True))
    assert {each.frequency for each in made.swings} == {told["frequency"]}
    left, right, rear = (swing[f"{leg}_hip"] for leg in ("front_left", "front_right", "rear_right"))
    assert left.amplitude == right.amplitude == rear.amplitude == 0.3
    assert left.phase - right.phase == pytest.approx(1.0)
    assert right.phase - rear.phase == pytest.approx(0.5)
    # Their axes point to the right, and a role turns to the left.
    assert rear.offset - right.offset == pytest.approx(-2 * 0.1)


def test_joints_without_limits_turn_forward_in_front_and_backward_at_the_rear() -> None:
    robot = load("hexapod_swimmer")
    family = gait(robot)
    made = family.policy(family.start)
    turn = 2.0 * math.pi * made.swings[0].frequency
    rates = {a.actuator: s.rate for a, s in zip(made.action, made.swings, strict=True)}
    assert rates["left_front"] == pytest.approx(turn)
    assert rates["right_rear"] == pytest.approx(-turn)
    assert rates["left_middle"] == 0.0
    # In one period the commands come round once: nothing jumps and nothing drifts.
    period = 1.0 / made.swings[0].frequency
    first, later = made.act(np.empty((2, 0)), np.array([0.1, 0.1 + period]))
    turns = (later - first) / (2.0 * math.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)


@pytest.mark.parametrize("body", ["quadruped_four_bar", "sea_snake", "swimmer_three_links"])
def test_every_point_of_the_cube_is_a_policy_within_its_bounds(body: str) -> None:
    family = gait(load(body))
    rng = np.random.default_rng(0)
    for point in rng.uniform(-0.2, 1.2, size=(20, len(family.numbers))):
        told = family.policy(point).act(np.empty((50, 0)), np.linspace(0.0, 5.0, 50))
        assert np.isfinite(told).all()
        assert (told >= [a.low for a in family.action]).all()
        assert (told <= [a.high for a in family.action]).all()


def test_a_start_beyond_its_bounds_is_refused() -> None:
    with pytest.raises(SearchError, match="begins at 3 within 0 and 1"):
        Number(name="amplitude", low=0.0, high=1.0, start=3.0)


def test_only_the_roles_that_are_asked_for_swing() -> None:
    robot = load("humanoid")
    family = gait(robot, roles=("hip_y", "knee_y"))
    made = family.policy(family.start)
    swinging = {a.actuator for a, s in zip(made.action, made.swings, strict=True) if s.amplitude}
    assert swinging == {"l_hip_y", "r_hip_y", "l_knee_y", "r_knee_y"}
    with pytest.raises(SearchError, match="a gait of wing was asked for"):
        gait(robot, roles=("wing",))
