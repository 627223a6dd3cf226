"""A pattern commands what its law says, and nothing else."""

from __future__ import annotations

import math

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import PolicyError, RobotError
from morph.policy.pattern import Pattern, Swing, pattern
from morph.policy.policy import UNLIMITED, Action, Observation, actions_of
from morph.sim.simulator import Simulator


@pytest.fixture(scope="module")
def swimmer() -> Robot:
    return load("hexapod_swimmer")


def test_a_swing_is_at_its_middle_at_the_start_and_at_its_end_a_quarter_later(
    swimmer: Robot,
) -> None:
    swing = Swing(offset=0.3, amplitude=0.5, frequency=2.0)
    policy = pattern(swimmer, {"left_rear": swing}, period=0.005)
    # A period lasts 0.5 s: its quarters end at 0.125, 0.25 and 0.375 s.
    told = policy.by_clock("left_rear", np.array([0.0, 0.125, 0.25, 0.375, 0.5]))
    assert told == pytest.approx([0.3, 0.8, 0.3, -0.2, 0.3], abs=1e-12)


def test_a_leg_that_turns_comes_round_once_a_period_whatever_its_sine(swimmer: Robot) -> None:
    leg = Swing(rate=2.0 * math.pi, amplitude=0.7, frequency=1.0, phase=0.4)
    policy = pattern(swimmer, {"left_rear": leg})
    told = policy.by_clock("left_rear", np.array([0.25, 1.25, 2.25]))
    assert np.diff(told) == pytest.approx(2.0 * math.pi, abs=1e-12)


def test_actuators_that_are_not_named_are_told_zero(swimmer: Robot) -> None:
    policy = pattern(swimmer, {"left_rear": Swing(offset=1.0)})
    told = policy.act(np.empty((3, 0)), np.array([0.0, 1.0, 2.0]))
    names = [actuator.name for actuator in swimmer.actuators]
    assert told.shape == (3, 6)
    assert np.array_equal(told, np.array([[name == "left_rear" for name in names]] * 3, float))


def test_a_command_holds_for_the_control_period(swimmer: Robot) -> None:
    policy = pattern(swimmer, {"left_rear": Swing(rate=1.0)}, period=0.1)
    # 0.3 is a little less than 3 times 0.1 in floating point, and is the third period.
    times = np.array([0.0, 0.05, 0.0999, 0.1, 0.199, 3 * 0.1, 0.3, 0.35])
    told = policy.by_clock("left_rear", times)
    assert told == pytest.approx([0.0, 0.0, 0.0, 0.1, 0.1, 0.3, 0.3, 0.3], abs=1e-9)


def test_a_motor_is_never_told_more_than_its_limit() -> None:
    robot = load("cartpole")
    (action,) = actions_of(robot)
    assert action.low == -action.high
    assert action.high < UNLIMITED
    policy = pattern(robot, {action.actuator: Swing(amplitude=1e3, frequency=1.0)}, period=0.01)
    told = policy.by_clock(action.actuator, np.linspace(0.0, 1.0, 101))
    assert (told.min(), told.max()) == (action.low, action.high)


def test_a_simulation_is_told_what_the_pattern_says(swimmer: Robot) -> None:
    policy = pattern(swimmer, {"left_rear": Swing(amplitude=0.2, frequency=1.0)}, period=0.01)
    run = Simulator(swimmer, step=0.005).run(seconds=0.2, command=policy.commands())
    for k, value in enumerate(run["left_rear.command"]):
        # Two steps of 5 ms share a command.
        assert value == pytest.approx(0.2 * math.sin(2.0 * math.pi * 0.01 * (k // 2)), abs=1e-12)
    assert not run["right_rear.command"].any()


def test_a_name_that_is_not_the_robots_is_refused(swimmer: Robot) -> None:
    with pytest.raises(RobotError, match="no actuator 'left_wing'"):
        pattern(swimmer, {"left_wing": Swing()})
    with pytest.raises(PolicyError, match="not 'left_wing'"):
        pattern(swimmer, {}).by_clock("left_wing", np.zeros(1))


@pytest.mark.parametrize("name", ["offset", "amplitude", "frequency", "phase", "rate"])
@pytest.mark.parametrize("value", [math.nan, math.inf, -2e6])
def test_a_swing_that_is_no_number_is_refused(name: str, value: float) -> None:
    with pytest.raises(PolicyError, match=f"{name} = "):
        Swing(**{name: value})


@pytest.mark.parametrize("period", [0.0, -1.0, math.nan, 11.0])
def test_a_control_period_out_of_range_is_refused(swimmer: Robot, period: float) -> None:
    with pytest.raises(PolicyError, match="control period"):
        pattern(swimmer, {}, period=period)


@pytest.mark.parametrize("bounds", [(1.0, -1.0), (math.nan, 1.0), (0.0, math.inf)])
def test_bounds_that_bound_nothing_are_refused(bounds: tuple[float, float]) -> None:
    with pytest.raises(PolicyError, match="bounds"):
        Action(actuator="a", unit="rad", low=bounds[0], high=bounds[1])


def test_a_pattern_observes_nothing_and_has_a_swing_for_each_actuator(swimmer: Robot) -> None:
    action = actions_of(swimmer)
    with pytest.raises(PolicyError, match="1 swings for 6 actions"):
        Pattern(swings=(Swing(),), action=action)
    seen = (Observation(channel="left_rear.position", unit="rad"),)
    with pytest.raises(PolicyError, match="1 observations"):
        Pattern(swings=(Swing(),) * 6, action=action, observation=seen)
