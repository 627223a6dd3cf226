"""What a designer may change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from morph.app.viewer.design.parameters import (
    changes,
    designed,
    effective,
    general,
    neutral,
    usable,
)
from morph.body.card import CardParameter
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import RobotError


def parameter(operation: str, low: float, high: float, link: str = "knee") -> CardParameter:
    return CardParameter(name=operation, operation=operation, link=link, low=low, high=high)


def test_any_body_can_be_larger_or_heavier_by_link(arm: Callable[..., Robot]) -> None:
    robot = arm()
    names = [each.name for each in general(robot)]
    assert names[:4] == ["whole body: size", "whole body: mass", "upper: size", "upper: mass"]
    heavier = designed(robot, general(robot), {"lower: mass": 1.5})
    assert heavier.mass == pytest.approx(2.0 + 1.5 * 1.0, abs=1e-12)
    assert heavier.card is None
    larger = designed(robot, general(robot), {"whole body: size": 2.0})
    # Mass grows as the cube of length.
    assert larger.mass == pytest.approx(8.0 * 3.0, abs=1e-9)


def test_a_body_with_nothing_set_is_the_body_itself(arm: Callable[..., Robot]) -> None:
    robot = arm()
    assert designed(robot, general(robot), {}) is robot


def test_a_card_keeps_its_parameters_when_others_are_set() -> None:
    robot = load("biped")
    assert robot.card is not None
    every = (*robot.card.parameter, *general(robot))
    found = designed(robot, every, {"torso_mass": 1.2, "torso: size": 1.1})
    assert found.card is not None
    assert found.card.parameter == robot.card.parameter


def test_parameters_begin_where_they_change_nothing() -> None:
    for each, plain in (
        (parameter("scale", 0.5, 2.0), 1.0),
        (parameter("heavier", 0.5, 2.0), 1.0),
        (parameter("stiffen", 0.0, 9.0), 0.0),
    ):
        assert neutral(each) == plain
        assert not changes(each, plain)
        assert changes(each, plain + 0.1)


def test_a_range_without_nothing_begins_at_its_end_which_is_a_change() -> None:
    each = parameter("scale", 1.2, 2.0)
    assert neutral(each) == 1.2
    assert changes(each, 1.2)


def test_a_lock_changes_a_body_wherever_it_holds() -> None:
    each = parameter("lock", 0.3, 1.0)
    assert neutral(each) == 0.3
    assert changes(each, 0.3)


def test_a_joint_that_is_locked_is_not_stiffened() -> None:
    robot = load("biped")
    assert robot.card is not None
    every = (
        parameter("lock", 0.0, 1.0, "left_foot"),
        replace(parameter("stiffen", 0.0, 9.0, "left_foot"), name="spring"),
    )
    assert effective(every, {"lock": 0.1, "spring": 2.0}) == {"lock": 0.1}
    assert effective(every, {"spring": 2.0}) == {"spring": 2.0}
    assert "left_ankle" not in [
        joint.name for joint in designed(robot, every, {"lock": 0.1, "spring": 2.0}).joints
    ]


def test_what_a_lock_took_away_cannot_be_used_again() -> None:
    robot = load("biped")
    assert robot.card is not None
    own = robot.card.parameter
    assert usable(robot, own) == own
    locked = designed(robot, own, {"left_knee_locked_at": 0.5})
    gone = {each.name for each in own} - {each.name for each in usable(locked, own)}
    assert gone == {"left_knee_locked_at"}


def test_a_value_beyond_its_range_is_refused() -> None:
    robot = load("biped")
    assert robot.card is not None
    with pytest.raises(RobotError, match=r"torso_mass is 9\.0, outside 0\.3 to 2\.0"):
        designed(robot, robot.card.parameter, {"torso_mass": 9.0})
