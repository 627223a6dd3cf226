"""Postures by name, against the description's own keyframes."""

from __future__ import annotations

from pathlib import Path

import pytest

from morph.body.load import load
from morph.body.postures import keyframes_of, posture_of, postured
from morph.body.robot import Robot
from morph.errors import RobotError

LEG = """<mujoco model="leg"><compiler angle="radian"/><worldbody>
<body name="trunk" pos="0 0 1"><freejoint/>
<geom size="0.1" mass="1"/><body name="shank" pos="0 0 -0.1">
<joint name="knee" axis="0 1 0" range="-1 1" limited="true"/>
<geom type="box" size="0.2 0.2 0.05" pos="0 0 -0.5" mass="1"/></body></body></worldbody>
<actuator><position joint="knee" kp="100"/></actuator>
<keyframe><key name="odd" qpos="0 0 2 1 0 0 0 0.5"/>KEY</keyframe></mujoco>"""
HOME = '<key name="home" qpos="0 0 0.65 1 0 0 0 0.1"/>'


def leg(folder: Path, key: str) -> Robot:
    (folder / "leg.xml").write_text(LEG.replace("KEY", key))
    return load(folder / "leg.xml")


def test_keyframes_are_told_by_joint_and_by_channel_of_the_base(tmp_path: Path) -> None:
    (odd,) = keyframes_of(leg(tmp_path, "")).values()
    assert odd["knee"] == 0.5
    assert odd["trunk.position.z"] == 2.0
    # What is as described is left out.
    assert odd.keys() == {"knee", "trunk.position.z"}


def test_a_quaternion_is_told_whole(tmp_path: Path) -> None:
    tilted = '<key name="tilted" qpos="0 0 1 0.6 0.8 0 0 0"/>'
    told = keyframes_of(leg(tmp_path, tilted))["tilted"]
    assert [told[f"trunk.orientation.{axis}"] for axis in "wxyz"] == [0.6, 0.8, 0.0, 0.0]


def test_a_robot_starts_at_home_else_on_its_feet(tmp_path: Path) -> None:
    assert posture_of(leg(tmp_path, HOME))["knee"] == 0.1
    # Its sole is 0.1 + 0.55 m below the trunk.
    assert posture_of(leg(tmp_path, ""))["trunk.position.z"] == pytest.approx(0.65)
    assert posture_of(load("so101")) == {}


def test_a_keyframe_beyond_a_range_starts_at_its_end_and_is_told(tmp_path: Path) -> None:
    robot = leg(tmp_path, '<key name="home" qpos="0 0 0.65 1 0 0 0 -1.25"/>')
    # The knee's range is -1 to 1 rad.
    assert posture_of(robot)["knee"] == -1.0
    (finding,) = [each for each in robot.findings if each.code == "keyframe-range"]
    assert (finding.severity, finding.where.name) == ("info", "knee")
    assert "keyframe home puts it at -1.25" in finding.what


def test_a_posture_is_named_or_read_from_a_file(tmp_path: Path) -> None:
    robot = leg(tmp_path, HOME)
    (tmp_path / "mine.toml").write_text('knee = -0.2\n"trunk.position.z" = 0.7\n')
    told = {name: posture_of(postured(robot, name)) for name in ("odd", "standing", "rest", "home")}
    assert told["odd"]["knee"] == 0.5
    assert told["standing"] == {"trunk.position.z": pytest.approx(0.65)}
    assert told["rest"] == {}
    mine = posture_of(postured(robot, str(tmp_path / "mine.toml")))
    assert mine == {"knee": -0.2, "trunk.position.z": 0.7}
    assert postured(robot, None) is robot


@pytest.mark.parametrize(
    ("text", "message"),
    [("knee = true", "knee is no finite number"), ("knee = ", "cannot be read"), (None, "cannot")],
)
def test_a_file_that_tells_no_posture_is_refused(
    text: str | None, message: str, tmp_path: Path
) -> None:
    if text is not None:
        (tmp_path / "mine.toml").write_text(text)
    with pytest.raises(RobotError, match=message):
        postured(load("biped"), str(tmp_path / "mine.toml"))


def test_a_posture_that_there_is_not_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match="no posture 'hom'") as refused:
        postured(leg(tmp_path, HOME), "hom")
    assert "'home'" in refused.value.fix
    with pytest.raises(RobotError, match="no feet"):
        postured(load("so101"), "standing")
