"""A joint that follows another follows it exactly, or is named if there is nothing to follow."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest

from morph.body.spec import spec_of


def follows(bench: Any, mimic: str, kind: str = "continuous") -> Any:
    """Return the reading of a robot whose second joint follows something."""
    return bench.read(
        *(bench.link(name) for name in "abc"),
        bench.joint("lead", "a", "b"),
        bench.joint("follower", "b", "c", kind, f"<mimic {mimic}/>", axis="0 1 0"),
    )


def test_a_follower_keeps_its_ratio_and_offset(bench: Any) -> None:
    reading = follows(bench, 'joint="lead" multiplier="-2" offset="0.3"')
    assert reading.findings == ()
    mimic = reading.robot.joint("follower").mimic
    assert (mimic.joint, mimic.ratio, mimic.offset) == ("lead", -2.0, 0.3)


def test_a_follower_without_numbers_copies_its_leader(bench: Any) -> None:
    # URDF, element mimic: multiplier is 1 and offset 0 without a word.
    mimic = follows(bench, 'joint="lead"').robot.joint("follower").mimic
    assert (mimic.ratio, mimic.offset) == (1.0, 0.0)


def test_mujoco_holds_the_law_of_a_follower(bench: Any) -> None:
    reading = follows(bench, 'joint="lead" multiplier="-2" offset="0.3"')
    model = spec_of(reading.robot).compile()
    data = mujoco.MjData(model)
    lead, follower = model.joint("lead").qposadr[0], model.joint("follower").qposadr[0]
    for position in (-0.7, 0.0, 1.1):
        data.qpos[lead], data.qpos[follower] = position, -2 * position + 0.3
        mujoco.mj_forward(model, data)
        # The constraint's residual: rounding where the law holds, and else what breaks it.
        assert np.abs(data.efc_pos[: data.nefc]).max() == pytest.approx(0.0, abs=1e-12)
        data.qpos[follower] += 0.1
        mujoco.mj_forward(model, data)
        assert np.abs(data.efc_pos[: data.nefc]).max() == pytest.approx(0.1, abs=1e-12)


def test_a_follower_has_no_motor_of_its_own(bench: Any) -> None:
    robot = follows(bench, 'joint="lead"').robot
    assert [actuator.joint for actuator in robot.actuators] == ["lead"]


@pytest.mark.parametrize("mimic", ['joint="nobody"', 'joint=""', 'joint="follower"', ""])
def test_a_follower_of_nothing_or_of_itself_moves_by_itself(bench: Any, mimic: str) -> None:
    reading = follows(bench, mimic)
    assert reading.stands("mimic", "repaired", "joint", "follower")
    assert reading.robot.joint("follower").mimic is None
    assert {actuator.joint for actuator in reading.robot.actuators} == {"lead", "follower"}


def test_a_follower_of_a_weld_moves_by_itself(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in "abc"),
        bench.joint("weld", "a", "b", "fixed"),
        bench.joint("follower", "b", "c", "continuous", '<mimic joint="weld"/>'),
    )
    assert reading.stands("mimic", "repaired", "joint", "follower")
    assert reading.robot.joint("follower").mimic is None


def test_two_joints_that_follow_each_other_are_named_once_at_least(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in "abc"),
        bench.joint("one", "a", "b", "continuous", '<mimic joint="two"/>'),
        bench.joint("two", "b", "c", "continuous", '<mimic joint="one"/>'),
    )
    assert reading.of("mimic")
    assert all(finding.severity == "repaired" for finding in reading.of("mimic"))
    assert sum(joint.mimic is not None for joint in reading.robot.joints) < 2


def test_a_follower_of_a_follower_is_allowed(bench: Any) -> None:
    reading = bench.read(
        *(bench.link(name) for name in "abcd"),
        bench.joint("one", "a", "b"),
        bench.joint("two", "b", "c", "continuous", '<mimic joint="one"/>'),
        bench.joint("three", "c", "d", "continuous", '<mimic joint="two" multiplier="3"/>'),
    )
    assert reading.findings == ()
    assert reading.robot.joint("three").mimic.joint == "two"


def test_a_weld_that_is_to_follow_stays_a_weld_and_it_is_said(bench: Any) -> None:
    reading = follows(bench, 'joint="lead"', "fixed")
    assert reading.stands("mimic", "info", "joint", "follower")
    assert [joint.name for joint in reading.robot.joints] == ["lead"]
