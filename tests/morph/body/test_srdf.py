"""Postures of SRDF files, against the numbers in them and against Pinocchio's reading."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from morph.body.convert import convert
from morph.body.load import load
from morph.body.postures import keyframes_of, posture_of, postured
from morph.body.srdf import srdf_postures
from morph.errors import RobotError

LINK = """<link name="{}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
URDF = "\n".join(
    (
        '<robot name="leg">',
        *(LINK.format(name) for name in ("hull", "thigh", "wheel")),
        JOINT.format("knee", "revolute", "hull", "thigh"),
        JOINT.format("spin", "continuous", "thigh", "wheel"),
        "</robot>",
    )
)
SRDF = """<robot name="leg"><group_state name="half_sitting" group="all">
<joint name="root_joint" value="0 0 0.4 0 0 0.6 0.8"/><joint name="knee" value=" 0.5 "/>
<joint name="spin" value="-1.5"/><joint name="gripper" value="0.1"/></group_state>
<group_state name="tall"><joint name="knee" value="-0.25"/></group_state>
<group_state name="of_others"><joint name="gripper" value="1"/></group_state></robot>"""


@pytest.fixture
def files(tmp_path: Path) -> Path:
    (tmp_path / "leg.urdf").write_text(URDF)
    (tmp_path / "leg.srdf").write_text(SRDF)
    return tmp_path


def test_postures_are_those_of_the_file(files: Path) -> None:
    robot = load(files / "leg.urdf", base="floating")
    known = srdf_postures(files / "leg.srdf", robot)
    sitting = {"hull.position.x": 0.0, "hull.position.y": 0.0, "hull.position.z": 0.4}
    sitting |= {"hull.orientation.x": 0.0, "hull.orientation.y": 0.0}
    sitting |= {"hull.orientation.z": 0.6, "hull.orientation.w": 0.8}
    sitting |= {"knee": 0.5, "spin": -1.5}
    assert known == {"half_sitting": sitting, "tall": {"knee": -0.25}}


def test_a_bolted_robot_takes_the_joints_alone(files: Path) -> None:
    known = srdf_postures(files / "leg.srdf", load(files / "leg.urdf", base="fixed"))
    assert known["half_sitting"].keys() == {"knee", "spin"}


def test_pinocchio_places_the_joints_alike(files: Path) -> None:
    model = pinocchio.buildModelFromUrdf(str(files / "leg.urdf"))
    pinocchio.loadReferenceConfigurations(model, str(files / "leg.srdf"), False)
    ours = srdf_postures(files / "leg.srdf", load(files / "leg.urdf", base="fixed"))
    theirs = model.referenceConfigurations["half_sitting"]
    knee, spin = ours["half_sitting"]["knee"], ours["half_sitting"]["spin"]
    # Pinocchio keeps a hinge without limits as cosine and sine, which round at 1e-16.
    np.testing.assert_allclose(theirs, [knee, np.cos(spin), np.sin(spin)], atol=1e-15)


def test_a_posture_is_named_behind_the_file(files: Path) -> None:
    robot = load(files / "leg.urdf", base="fixed")
    file = str(files / "leg.srdf")
    assert posture_of(postured(robot, f"{file}:tall")) == {"knee": -0.25}
    # Of several it is the one of a usual name.
    assert posture_of(postured(robot, file))["knee"] == 0.5
    with pytest.raises(RobotError, match="no posture 'tal'") as refused:
        postured(robot, f"{file}:tal")
    assert "'tall'" in refused.value.fix


def test_a_card_names_postures_of_files_beside_it(files: Path) -> None:
    folder = files / "leg"
    folder.mkdir()
    for name in ("leg.urdf", "leg.srdf"):
        (files / name).rename(folder / name)
    (folder / "low.toml").write_text("knee = 0.75\n")
    (folder / "card.toml").write_text(
        'schema = "morph.card/1"\nname = "leg"\ntitle = "Leg"\ndescription = "leg.urdf"\n'
        'base = "fixed"\nsource = []\nlicence = "Apache-2.0"\n'
        '[[posture]]\nname = "tall"\nfile = "leg.srdf"\n[[posture]]\nname = "home"\n'
        'file = "low.toml"\n'
    )
    robot = load(folder)
    assert keyframes_of(robot) == {"tall": {"knee": -0.25}, "home": {"knee": 0.75}}
    assert posture_of(robot) == {"knee": 0.75}
    # What is written has no such card, and has them as keyframes.
    convert(robot, "mjcf", files / "written")
    assert keyframes_of(load(files / "written" / "robot.xml")) == keyframes_of(robot)
    for text, message in (("kne = 0.1", "names 'kne'"), (f"knee = {'9' * 400}", "finite number")):
        (folder / "low.toml").write_text(text)
        with pytest.raises(RobotError, match=message):
            load(folder)
    (folder / "low.toml").unlink()
    with pytest.raises(RobotError, match="posture cannot be read"):
        load(folder)


@pytest.mark.parametrize("second", ["rest", "tall"])
def test_a_card_may_not_call_two_postures_alike(files: Path, second: str) -> None:
    (files / "card.toml").write_text(
        f'schema = "morph.card/1"\nname = "{files.name}"\ntitle = "Leg"\n'
        'description = "leg.urdf"\nbase = "fixed"\nsource = []\nlicence = "Apache-2.0"\n'
        '[[posture]]\nname = "tall"\nfile = "leg.srdf"\n'
        f'[[posture]]\nname = "{second}"\nfile = "leg.srdf"\n'
    )
    with pytest.raises(RobotError, match="as another is called"):
        load(files)


def test_a_posture_that_says_no_height_stands_on_the_floor(files: Path) -> None:
    text = URDF.replace(
        "</link>", '<collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
    )
    (files / "leg.urdf").write_text(text)
    robot = load(files / "leg.urdf", base="floating")
    told = posture_of(postured(robot, f"{files / 'leg.srdf'}:tall"))
    assert told == {"knee": -0.25}
    (files / "card.toml").write_text(
        f'schema = "morph.card/1"\nname = "{files.name}"\ntitle = "Leg"\n'
        'description = "leg.urdf"\nbase = "floating"\nsource = []\nlicence = "Apache-2.0"\n'
        '[[posture]]\nname = "home"\nfile = "home.toml"\n'
    )
    (files / "home.toml").write_text("knee = 0.5\n")
    # Its hull is a ball of 0.1 m at the origin, lifted until it touches.
    assert posture_of(load(files)) == {"knee": 0.5, "hull.position.z": pytest.approx(0.1)}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (' 0.5 "', ' bent "', "has the value ' bent '"),
        (' 0.5 "', ' nan "', "has the value ' nan '"),
        (' 0.5 "', ' 1 2 3 "', "'knee' is a hinge and has 3 values"),
        ("0 0 0.6 0.8", "0 0 0 0", "a quaternion of length 0"),
        ("<robot", "<mujoco", "not XML"),
        ("0 0 0.6 0.8", "0 0 1e200 1e200", "a quaternion of length 1.41e"),
    ],
)
def test_values_that_a_joint_cannot_have_are_refused(
    old: str, new: str, message: str, files: Path
) -> None:
    file = files / "leg.srdf"
    file.write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(RobotError, match=message):
        srdf_postures(file, load(files / "leg.urdf", base="floating"))


def test_a_file_without_a_posture_of_the_robot_is_refused(files: Path) -> None:
    (files / "leg.srdf").write_text('<robot name="leg"/>')
    with pytest.raises(RobotError, match="holds 0 postures"):
        postured(load(files / "leg.urdf"), str(files / "leg.srdf"))
