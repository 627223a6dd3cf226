"""Both engines read the URDF of a body that floats alike."""

from __future__ import annotations

from pathlib import Path

import pytest

from morph.body import shelf
from morph.body.agreement import disagreement
from morph.body.convert import convert
from morph.body.load import load

MASS = (
    '<inertial><mass value="2"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)

FLOATING = [
    name for name in shelf.names() if any(joint.kind == "free" for joint in load(name).joints)
]


@pytest.mark.parametrize("name", FLOATING)
def test_a_floating_body_written_as_urdf_is_read_alike(name: str, tmp_path: Path) -> None:
    written = convert(load(name), "urdf", tmp_path / name)
    assert disagreement(load(written.files[0])) == []


def test_there_are_bodies_that_float() -> None:
    assert {"humanoid", "sea_snake", "hexapod_swimmer"} <= set(FLOATING)


@pytest.mark.parametrize("base", ["floating", "board"])
def test_a_base_that_a_flag_frees_is_read_alike(base: str, tmp_path: Path) -> None:
    path = tmp_path / "lever.urdf"
    path.write_text(
        f'<robot name="lever"><link name="hull">{MASS}</link><link name="arm">{MASS}</link>'
        '<joint name="hinge" type="continuous"><origin xyz="0.3 0 0"/>'
        '<parent link="hull"/><child link="arm"/></joint></robot>'
    )
    assert disagreement(load(path, base=base)) == []


def test_a_floating_joint_further_down_keeps_its_place(tmp_path: Path) -> None:
    path = tmp_path / "kite.urdf"
    path.write_text(
        f'<robot name="kite"><link name="hull">{MASS}</link><link name="arm">{MASS}</link>'
        '<joint name="rope" type="floating"><origin xyz="0.3 0 0.4"/>'
        '<parent link="hull"/><child link="arm"/></joint></robot>'
    )
    assert disagreement(load(path)) == []


def test_of_a_body_with_very_many_joints_the_second_opinion_is_not_asked(tmp_path: Path) -> None:
    path = tmp_path / "brush.urdf"
    hairs = "".join(
        f'<link name="hair_{number}">{MASS}</link><joint name="joint_{number}" type="continuous">'
        f'<parent link="hull"/><child link="hair_{number}"/></joint>'
        for number in range(160)
    )
    path.write_text(f'<robot name="brush"><link name="hull">{MASS}</link>{hairs}</robot>')
    (told,) = disagreement(load(path))
    assert "160 degrees of freedom" in told.what
    assert told.done == "Pinocchio was not asked"
