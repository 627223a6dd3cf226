"""Efforts that stand for commands, against MuJoCo's own actuator forces."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from morph.body.robot import Robot
from morph.model.derived_channels import by_effort, told_zero
from morph.record.recording import Channel, Recording

GEARED = """
<mujoco model="geared">
  <worldbody><body name="arm"><joint name="hinge" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="1"/></body></worldbody>
  <actuator><general name="motor" joint="hinge" gear="3" gainprm="0.5"/></actuator>
</mujoco>
"""
TIME = np.linspace(0.0, 1.0, 11)


def recording(**channels: np.ndarray) -> Recording:
    held = {
        name.replace("_", "."): Channel(time=TIME, value=each) for name, each in channels.items()
    }
    return Recording(name="run", channels=held)


def test_a_command_makes_the_effort_that_it_is_taken_from(body: Callable[[str], Robot]) -> None:
    robot, effort = body(GEARED), np.sin(5.0 * TIME)
    found = by_effort(recording(hinge_effort=effort), robot)
    model = mujoco.MjModel.from_xml_string(GEARED)
    data, made = mujoco.MjData(model), []
    for command in found["motor.command"]:
        data.ctrl[:] = command
        mujoco.mj_forward(model, data)
        made.append(float(data.qfrc_actuator[0]))
    assert made == pytest.approx(effort, abs=1e-12)
    assert [note.what for note in found.notes] == [
        "motor has no recorded command: the effort measured at its joint is taken for it"
    ]


def test_an_effort_that_changes_all_the_while_is_not_taken_late(
    body: Callable[[str], Robot],
) -> None:
    found = by_effort(recording(hinge_effort=np.sin(5.0 * TIME)), body(GEARED))
    times = np.linspace(0.1, 0.9, 4001)
    held, true = found.channel("motor.command").at(times), np.sin(5.0 * times) / 1.5
    # Its error by the slope is how late it is: half a period, 50 ms, if each reading is held until
    # the next. About the readings errors of either sign cancel: a tenth of that is left at most.
    slope = np.gradient(true, times)
    assert abs(np.mean((held - true) * slope) / np.mean(slope**2)) < 0.005


def test_a_command_that_was_recorded_stays(body: Callable[[str], Robot]) -> None:
    given = recording(hinge_effort=np.ones(11), motor_command=np.zeros(11))
    assert by_effort(given, body(GEARED)) is given
    assert told_zero(given, body(GEARED)) is given


def test_without_effort_or_command_a_motor_is_told_zero(body: Callable[[str], Robot]) -> None:
    robot, given = body(GEARED), recording(hinge_position=np.zeros(11))
    assert by_effort(given, robot) is given
    found = told_zero(given, robot)
    assert not found.channel("motor.command").at(TIME).any()
    assert "told 0" in found.notes[0].what


def test_an_effort_is_not_told_to_two_motors_of_its_joint(body: Callable[[str], Robot]) -> None:
    second = '<motor name="second" joint="hinge"/></actuator>'
    robot = body(GEARED.replace("</actuator>", second))
    given = recording(hinge_effort=np.ones(11))
    assert by_effort(given, robot) is given
