from __future__ import annotations

import os
from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import pytest
import yourdfpy

from morph.body.convert import FORMATS, convert
from morph.body.load import load
from morph.body.mesh import as_stl
from morph.body.urdf_shapes import ellipsoid
from morph.body.urdf_text import LEAST, urdf_text, writable


def masses(path: Path) -> dict[str, float]:
    """Return the mass that each reader finds in a description."""
    found = {"mujoco": float(mujoco.MjModel.from_xml_path(str(path)).body_mass.sum())}
    if path.suffix == ".xml":
        twin = pinocchio.buildModelFromMJCF(str(path))
    else:
        twin = pinocchio.buildModelFromUrdf(str(path))
        links = yourdfpy.URDF.load(str(path)).robot.links
        found["yourdfpy"] = sum(link.inertial.mass for link in links if link.inertial is not None)
    found["pinocchio"] = sum(inertia.mass for inertia in twin.inertias)
    return found


NAMES = ("two words", "a/b\\c", "Größe 関節", "<&>\"'", "100 % #?:*", "x" * 150, ".", "..")


@pytest.mark.parametrize("to", FORMATS)
@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_any_name_comes_through(name: str, to: str, tmp_path: Path) -> None:
    mesh = as_stl(ellipsoid(0.1, 0.2, 0.3))
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "part (1) & co.stl").write_bytes(mesh)
    quoted = name.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    inertial = (
        '<inertial><mass value="2"/>'
        '<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    source = tmp_path / "in" / "robot.urdf"
    source.write_text(
        f'<robot name="{quoted}"><link name="base"/><link name="{quoted}">{inertial}<visual>'
        '<geometry><mesh filename="part (1) &amp; co.stl"/></geometry></visual></link>'
        f'<joint name="{quoted}" type="continuous"><parent link="base"/><child link="{quoted}"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )
    robot = load(source, base="fixed")
    path = convert(robot, to, tmp_path / "out").files[0]
    assert path.is_relative_to(tmp_path / "out")
    assert masses(path) == dict.fromkeys(masses(path), 2.0)
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.body(name).mass == 2.0
    assert model.joint(name).type == mujoco.mjtJoint.mjJNT_HINGE
    assert model.nmesh == 1


def test_a_joint_that_follows_another_still_does(tmp_path: Path) -> None:
    finger = "<body name='{0}'><joint name='{0}'/><geom size='1' mass='1'/></body>"
    (tmp_path / "robot.xml").write_text(
        f"<mujoco><worldbody>{finger.format('a')}{finger.format('b')}{finger.format('c')}"
        "</worldbody><equality><joint joint1='b' joint2='a' polycoef='0.2 -3 0 0 0'/>"
        "<joint joint1='c' joint2='a' polycoef='0 1 1 0 0'/></equality></mujoco>"
    )
    conversion = convert(load(tmp_path / "robot.xml"), "urdf", tmp_path / "out")
    again = load(conversion.files[0])
    follows = again.joint("b").mimic
    assert follows is not None
    assert (follows.joint, follows.ratio, follows.offset) == ("a", -3.0, 0.2)
    assert "how 'c' is tied" in conversion.left_out


def test_what_urdf_cannot_hold_is_said(tmp_path: Path) -> None:
    left_out = convert(load("quadruped_four_bar"), "urdf", tmp_path / "a").left_out
    assert "the closed chain front_left_hip_pin" in left_out
    assert "the gains of 8 servos" in left_out
    assert any("rotors" in left for left in left_out)
    assert any("nothing drives front_left_hip_rod" in left for left in left_out)
    assert convert(load("quadruped_four_bar"), "mjcf", tmp_path / "b").left_out == ()


def test_shapes_without_a_mass_weigh_nothing(tmp_path: Path) -> None:
    # MuJoCo weighs the shapes of a URDF's link that has no inertia, unless it is told not to.
    (tmp_path / "robot.xml").write_text(
        "<mujoco><worldbody><body name='a'><joint/><geom size='1' mass='3'/><body name='foot'>"
        "<geom size='1' mass='0'/></body></body></worldbody></mujoco>"
    )
    path = convert(load(tmp_path / "robot.xml"), "urdf", tmp_path / "out").files[0]
    assert masses(path) == {"mujoco": 3.0, "pinocchio": 3.0, "yourdfpy": 3.0}


@pytest.mark.parametrize(
    "moments", [(0.0, 0.0, 0.0), (0.0, 2.0, 2.0), (1.0, 2.0, 3.0), (3.0, 1.0, 2.0), (1, 1, 1.5)]
)
def test_moments_that_are_written_are_a_bodys_and_hardly_others(
    moments: tuple[float, float, float],
) -> None:
    held = writable(np.array(moments))
    assert held.min() >= LEAST
    assert 2 * held.max() < held.sum()
    # At most the margin of 1e-11 of the greatest, or the least that MuJoCo reads.
    assert np.abs(held - moments).max() <= max(2e-11 * max(moments), 2 * LEAST)


@pytest.mark.parametrize("name", [b"\xff", b"\x01\x1b"])
def test_a_robot_named_by_a_file_that_is_no_text_is_written(name: bytes, tmp_path: Path) -> None:
    path = tmp_path / os.fsdecode(name + b".xml")
    body = "<body><joint/><geom size='1' mass='2'/></body>"
    path.write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    assert masses(convert(load(path), "urdf", tmp_path / "out").files[0])["mujoco"] == 2.0
    assert masses(convert(load(path), "mjcf", tmp_path / "out").files[0])["mujoco"] == 2.0


def test_what_may_touch_what_is_told_where_urdf_forgets_it() -> None:
    told = "which of its parts may touch each other"
    assert told in urdf_text(load("humanoid"), "meshes")[2]
    assert told not in urdf_text(load("pendulum"), "meshes")[2]
