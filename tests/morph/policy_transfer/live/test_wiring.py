from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import TransferError
from morph.policy_transfer.live.protocol import Hello, Signal
from morph.policy_transfer.live.wiring import Wiring, hello_for
from morph.sim.simulator import Simulator
from morph.task.task import Task


def wired(swing: Task, hello: Hello) -> Wiring:
    model = swing.simulator().model
    return Wiring(swing.robot, model, hello, period=swing.period, where="target")


def test_channels_in_another_order_are_mapped_by_name(swing: Task) -> None:
    hello = hello_for(swing.robot, swing.period)
    wiring = wired(swing, replace(hello, channels=hello.channels[::-1]))
    said = {
        "hinge.velocity": 4.0,
        "slide.velocity": 3.0,
        "hinge.position": 2.0,
        "slide.position": 1.0,
    }
    position, velocity = wiring.state(said)
    # The body has the slide first.
    assert position.tolist() == [1.0, 2.0]
    assert velocity.tolist() == [3.0, 4.0]
    assert wiring.told(np.array([7.0])) == {"slide": 7.0}


def test_actuators_of_a_body_with_many_are_told_by_name() -> None:
    robot = load("so101")
    hello = hello_for(robot, 0.02)
    hello = replace(hello, actuators=hello.actuators[::-1])
    wiring = Wiring(robot, Simulator(robot).model, hello, period=0.02, where="target")
    told = wiring.told(np.arange(float(len(robot.actuators))))
    assert told == {each.name: float(at) for at, each in enumerate(robot.actuators)}


@pytest.mark.parametrize(
    ("name", "unit", "fix"),
    [
        # 1 degree is pi / 180 = 0.0174532925 rad.
        ("hinge.position", "deg", r"1 deg is 0.0174532925 \(pi / 180\) rad"),
        ("slide.position", "mm", r"1 mm is 0.001 m"),
        ("hinge.velocity", "rpm", r"1 rpm is 0.104719755 rad/s"),
        ("hinge.position", "m", r"m measures something else"),
        ("hinge.position", "ticks", r"ticks measures something else, or is not known"),
    ],
)
def test_another_unit_is_refused_with_its_factor(
    swing: Task, name: str, unit: str, fix: str
) -> None:
    hello = hello_for(swing.robot, swing.period)
    channels = tuple(
        Signal(name=x.name, unit=unit) if x.name == name else x for x in hello.channels
    )
    with pytest.raises(TransferError, match=rf"its channel '{name}' is in {unit}") as error:
        wired(swing, replace(hello, channels=channels))
    assert error.match(fix)


def test_a_missing_channel_is_refused_with_the_nearest(swing: Task) -> None:
    hello = hello_for(swing.robot, swing.period)
    channels = (*hello.channels[:1], Signal(name="hinge.pos", unit="rad"), *hello.channels[2:])
    with pytest.raises(TransferError, match=r"no channel 'hinge.position' \(rad\).*'hinge.pos'"):
        wired(swing, replace(hello, channels=channels))


def test_an_actuator_in_another_unit_or_too_many_are_refused(swing: Task) -> None:
    hello = hello_for(swing.robot, swing.period)
    with pytest.raises(TransferError, match=r"its actuator 'slide' is in V, and cartpole has it"):
        wired(swing, replace(hello, actuators=(Signal(name="slide", unit="V"),)))
    more = (*hello.actuators, Signal(name="brake", unit="N"))
    with pytest.raises(TransferError, match=r"it has the actuator brake, which cartpole lacks"):
        wired(swing, replace(hello, actuators=more))


def test_another_period_is_refused(swing: Task) -> None:
    with pytest.raises(TransferError, match=r"every 0.02 s, and the task counts every 0.05 s"):
        wired(swing, hello_for(swing.robot, 0.02))


def test_a_channel_more_is_named_and_not_used(swing: Task) -> None:
    hello = hello_for(swing.robot, swing.period)
    more = (*hello.channels, Signal(name="battery", unit="V"))
    assert wired(swing, replace(hello, channels=more)).unused == ("battery",)


def test_what_is_no_number_is_named(swing: Task) -> None:
    wiring = wired(swing, hello_for(swing.robot, swing.period))
    state = wiring.state({"slide.position": 0.0, "slide.velocity": None, "hinge.position": "1"})
    assert wiring.missing(*state) == ["slide.velocity", "hinge.position", "hinge.velocity"]
    assert math.isnan(state[0][1])
