"""What an environment shows and takes, held against what policies observe and command."""

from __future__ import annotations

import pytest

from morph.body.load import load
from morph.body.robot import Actuator, Joint, Robot
from morph.body.spec import spec_of
from morph.policy.observing import addresses, observations_of
from morph.task.gym.spaces import FREE, FREE_HINGE, channels, columns, command_range


@pytest.mark.parametrize("name", ["cartpole", "hopper", "sea_snake", "quadruped_four_bar"])
def test_what_is_seen_stands_in_the_order_in_which_policies_see_it(name: str) -> None:
    robot = load(name)
    seen = [each.channel for each in observations_of(robot)]
    assert list(channels(robot)) == seen
    model = spec_of(robot).compile()
    where = addresses(robot, model)
    assert columns(robot, model, seen).tolist() == [where[each] for each in seen]


def body(kind: str, joint: str, limits: tuple[float, float] | None, effort: float | None) -> Robot:
    return Robot(
        name="one",
        links=(),
        joints=(Joint(name="j", kind=joint, link="l", limits=limits),),
        actuators=(Actuator(name="a", joint="j", kind=kind, limit=effort),),
        mjcf="",
    )


@pytest.mark.parametrize(
    ("robot", "low", "high"),
    [
        (body("motor", "hinge", (-1.0, 1.0), 4.0), -4.0, 4.0),
        (body("motor", "slide", None, None), -FREE, FREE),
        (body("position", "hinge", (-0.5, 2.0), 4.0), -0.5, 2.0),
        (body("position", "hinge", None, 4.0), -FREE_HINGE, FREE_HINGE),
        (body("position", "slide", None, 4.0), -FREE, FREE),
    ],
)
def test_an_action_of_one_is_the_greatest_command(robot: Robot, low: float, high: float) -> None:
    found = command_range(robot)
    assert (found[0].tolist(), found[1].tolist()) == ([low], [high])
