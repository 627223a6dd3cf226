from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import RobotError
from morph.sim.simulator import Simulator
from morph.sim.start import PLACES, started


@pytest.fixture(scope="module")
def swimmer() -> Robot:
    return load("hexapod_swimmer")


def test_a_floating_body_starts_where_and_as_fast_as_it_is_told(swimmer: Robot) -> None:
    start = {"hull.position.z": 0.5, "hull.position.x": -2.0}
    speed = {"hull.linear_velocity.y": 0.7, "hull.angular_velocity.z": -1.5}
    run = Simulator(swimmer).run(
        seconds=0.01,
        start={**start, "left_front": 0.3},
        speed={**speed, "left_front": 2.0},
    )
    first = {name: channel.value[0] for name, channel in run.channels.items()}
    told = start | speed | {"left_front.position": 0.3, "left_front.velocity": 2.0}
    assert {name: first[name] for name in told} == told
    rest = {name: value for name, value in first.items() if name not in told}
    assert {name for name, value in rest.items() if value} == {"hull.orientation.w"}


def test_an_orientation_told_in_part_is_zero_in_the_rest_and_of_length_one(swimmer: Robot) -> None:
    model = Simulator(swimmer).model
    # A quarter turn about z is (1, 0, 0, 1) / sqrt(2); upside down about x is (0, 1, 0, 0).
    for told, due in (
        ({"hull.orientation.w": 3.0, "hull.orientation.z": 3.0}, [0.5**0.5, 0.0, 0.0, 0.5**0.5]),
        ({"hull.orientation.x": 0.1}, [0.0, 1.0, 0.0, 0.0]),
        ({"hull.position.x": 1.0}, [1.0, 0.0, 0.0, 0.0]),
    ):
        position, velocity = started(swimmer, model, told)
        assert position[3:7] == pytest.approx(due, abs=1e-15)
        assert not velocity.any()


@pytest.mark.parametrize(
    ("told", "what", "fix"),
    [
        ({"hull.position.q": 1.0}, "there is no 'hull.position.q'; of hull, which", "position.x"),
        ({"hull.linear_velocity.x": 1.0}, "there is no 'hull.linear_velocity.x'", "nearest"),
        ({"left_front_paddle.position.x": 1.0}, "there is no joint", "name one of these joints"),
        ({"root": 1.0}, "the free joint 'root' has no single position", "say hull.position.x"),
        ({"hull.orientation.w": 0.0}, "its orientation is all zero", "hull.orientation.w = 1"),
    ],
)
def test_a_start_that_the_robot_cannot_have_is_refused(
    swimmer: Robot, told: dict[str, float], what: str, fix: str
) -> None:
    with pytest.raises(RobotError, match=what) as caught:
        Simulator(swimmer).run(seconds=0.01, start=told)
    assert caught.value.where.startswith("robot hexapod_swimmer")
    assert fix in caught.value.fix


def test_the_order_of_the_names_is_that_of_the_engine(swimmer: Robot) -> None:
    told = {f"hull.{name}": float(at + 1) for at, name in enumerate(PLACES)}
    position, _ = started(swimmer, Simulator(swimmer).model, told)
    assert position[:3].tolist() == [1.0, 2.0, 3.0]
    assert position[3:7] == pytest.approx(np.array([4.0, 5.0, 6.0, 7.0]) / 126.0**0.5)
