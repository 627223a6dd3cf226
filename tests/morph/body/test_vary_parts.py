"""What hangs on links: meshes, keyframes, closed loops, tendons and sensors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.vary import Add, Drop, Heavier, Lock, Scale, removed, vary

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
SOLID = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"


def described(text: str, folder: Path) -> Robot:
    """Return the robot of an MJCF text."""
    (folder / "part.obj").write_text(TETRAHEDRON)
    (folder / "made.xml").write_text(f"<mujoco model='made'>{text}</mujoco>")
    return load(folder / "made.xml")


def at_home(robot: Robot) -> tuple[Any, Any]:
    model = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def corners(robot: Robot, geom: int) -> Array:
    """Return the corners of a mesh geom in the world, sorted, m."""
    model, data = at_home(robot)
    mesh = model.geom_dataid[geom]
    first = model.mesh_vertadr[mesh]
    points = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
    found = points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    return found[np.lexsort(found.round(6).T)]


TWINS = (
    "<asset><mesh name='part' file='part.obj'/></asset><worldbody>"
    f"<body name='one' pos='1 0 0'>{SOLID}<joint name='first'/>"
    "<geom type='mesh' mesh='part' pos='0.1 0.2 0.3' quat='0.8 0.6 0 0'/></body>"
    f"<body name='other' pos='-1 0 0'>{SOLID}<joint name='second'/>"
    "<geom type='mesh' mesh='part'/></body></worldbody>"
)


def test_a_mesh_is_scaled_for_one_link_and_not_for_another(tmp_path: Path) -> None:
    robot = described(TWINS, tmp_path)
    after = vary(robot, Scale(link="one", factor=3.0))
    about = np.array((1.0, 0.0, 0.0))
    # MuJoCo holds the corners of meshes in single precision: 1e-7 of 10 m.
    wanted = about + 3 * (corners(robot, 0) - about)
    assert np.abs(corners(after, 0) - wanted).max() < 1e-5
    assert np.abs(corners(after, 1) - corners(robot, 1)).max() < 1e-6


def test_a_mesh_is_stretched_along_an_axis_of_its_own(tmp_path: Path) -> None:
    robot = described(TWINS, tmp_path)
    after = vary(robot, Scale(link="other", factor=2.0, along=(0.0, 1.0, 0.0)))
    wanted = corners(robot, 1) * np.array((1.0, 2.0, 1.0))
    assert np.abs(corners(after, 1) - wanted[np.lexsort(wanted.round(6).T)]).max() < 1e-5


def test_mesh_files_come_along_however_often_a_body_is_varied(tmp_path: Path) -> None:
    robot = described(TWINS, tmp_path)
    for path in tmp_path.iterdir():
        path.unlink()
    twice = vary(vary(robot, Heavier(link="one", factor=2.0)), Scale(link="one", factor=2.0))
    assert dict(twice.assets) == dict(robot.assets)
    spec_of(twice).compile()


def test_a_shape_on_a_slant_follows_the_stretch_of_its_ends(tmp_path: Path) -> None:
    robot = described(
        f"<worldbody><body name='arm'>{SOLID}<joint/>"
        "<geom type='capsule' fromto='0 0 0 1 0 1' size='0.1'/></body></worldbody>",
        tmp_path,
    )
    model, data = at_home(vary(robot, Scale(link="arm", factor=2.0, along=(1.0, 0.0, 0.0))))
    half = data.geom_xmat[0].reshape(3, 3)[:, 2] * model.geom_size[0, 1]
    ends = sorted((data.geom_xpos[0] + sign * half).tolist() for sign in (-1, 1))
    assert np.abs(np.array(ends) - [[0, 0, 0], [2, 0, 1]]).max() < 1e-12


def test_a_link_is_scaled_about_its_joint_which_stays(tmp_path: Path) -> None:
    robot = described(
        f"<worldbody><body name='arm' pos='0 0 1'>{SOLID}<joint name='hinge' pos='0.5 0 0'/>"
        "<site name='held' pos='0.5 0 0'/><site name='tip' pos='1.5 0 0'/></body></worldbody>",
        tmp_path,
    )
    _, data = at_home(vary(robot, Scale(link="arm", factor=2.0)))
    assert data.site("held").xpos == pytest.approx([0.5, 0, 1], abs=1e-15)
    assert data.site("tip").xpos == pytest.approx([2.5, 0, 1], abs=1e-15)


def test_the_travel_of_a_slide_scales_with_its_link(tmp_path: Path) -> None:
    robot = described(
        f"<worldbody><body name='cart'>{SOLID}<joint name='rail' type='slide' axis='1 0 0'"
        " range='-1 2' limited='true'/></body></worldbody><actuator><position name='servo'"
        " joint='rail' kp='10' ctrlrange='-1 2'/><motor name='motor' joint='rail'"
        " ctrlrange='-5 5'/></actuator>",
        tmp_path,
    )
    model = spec_of(vary(robot, Scale(link="cart", factor=1.5))).compile()
    assert model.joint("rail").range == pytest.approx([-1.5, 3.0])
    assert model.actuator("servo").ctrlrange == pytest.approx([-1.5, 3.0])
    assert model.actuator("motor").ctrlrange == pytest.approx([-5.0, 5.0])


KEYED = (
    f"<worldbody><body name='base' pos='0 0 1'>{SOLID}<freejoint name='root'/>"
    f"<body name='arm'>{SOLID}<joint name='first'/><body name='hand'>{SOLID}"
    "<joint name='second'/></body></body></body></worldbody><actuator><motor name='first'"
    " joint='first'/><motor name='second' joint='second'/></actuator><keyframe><key"
    " name='stand' qpos='1 2 3 1 0 0 0 0.5 0.7' ctrl='4 5'/></keyframe>"
)


def test_a_keyframe_outlives_the_joints_that_go_and_come(tmp_path: Path) -> None:
    robot = described(KEYED, tmp_path)
    locked = spec_of(vary(robot, Lock(joint="first"))).compile()
    assert locked.key_qpos[0].tolist() == [1, 2, 3, 1, 0, 0, 0, 0.7]
    assert locked.key_ctrl[0].tolist() == [5]
    dropped = spec_of(vary(robot, Drop(link="hand"))).compile()
    assert dropped.key_qpos[0].tolist() == [1, 2, 3, 1, 0, 0, 0, 0.5]
    added = vary(robot, Add(link="tail", parent="arm", mass=1.0, joint="wag", motor=1.0))
    model = spec_of(added).compile()
    key = dict(zip([joint.name for joint in added.joints][1:], model.key_qpos[0][7:], strict=True))
    assert key == {"first": 0.5, "second": 0.7, "wag": 0.0}


def test_a_whole_body_that_is_scaled_stands_as_it_stood(tmp_path: Path) -> None:
    robot = described(KEYED, tmp_path)
    model = spec_of(vary(robot, Scale(link="*", factor=2.0))).compile()
    assert model.key_qpos[0].tolist() == [2, 4, 6, 1, 0, 0, 0, 0.5, 0.7]
    assert model.qpos0[:3].tolist() == [0, 0, 2]


TIED = (
    f"<worldbody><body name='left'>{SOLID}<joint name='a' axis='0 1 0'/></body>"
    f"<body name='right' pos='1 0 0'>{SOLID}<joint name='b' axis='0 1 0'/></body></worldbody>"
    "<equality><connect name='pin' body1='left' body2='right' anchor='0.5 0 0.2'/>"
    "<joint name='gear' joint1='a' joint2='b'/></equality>"
    "<tendon><fixed name='belt'><joint joint='a' coef='1'/><joint joint='b' coef='1'/></fixed>"
    "</tendon><actuator><motor name='drive' joint='b'/></actuator><sensor>"
    "<jointpos name='angle' joint='b'/><actuatorfrc name='effort' actuator='drive'/>"
    "<tendonpos name='slack' tendon='belt'/></sensor>"
)


def test_all_that_refers_to_a_locked_joint_goes_and_is_named(tmp_path: Path) -> None:
    robot = described(TIED, tmp_path)
    gone = {"joint 'b'", "actuator 'drive'", "sensor 'angle'", "sensor 'effort'",
            "sensor 'slack'", "tendon 'belt'", "equality 'gear'"}  # fmt: skip
    assert set(removed(robot, Lock(joint="b"))) == gone
    assert spec_of(vary(robot, Lock(joint="b"))).compile().neq == 1


def test_what_goes_with_a_link_takes_its_loops_along(tmp_path: Path) -> None:
    robot = described(TIED, tmp_path)
    gone = removed(robot, Drop(link="right"))
    assert {"equality 'pin'", "equality 'gear'", "tendon 'belt'", "sensor 'effort'"} <= set(gone)
    assert spec_of(vary(robot, Drop(link="right"))).compile().neq == 0


@pytest.mark.parametrize("link", ["left", "right", "*"])
def test_a_pinned_loop_stays_closed_at_home_when_a_link_is_scaled(
    link: str, tmp_path: Path
) -> None:
    model, data = at_home(vary(described(TIED, tmp_path), Scale(link=link, factor=1.7)))
    # A pin holds three coordinates, and they come first. The anchor is the left link's.
    assert np.abs(data.efc_pos[:3]).max() < 1e-12
    factor = 1.0 if link == "right" else 1.7
    assert model.eq_data[0, :3] == pytest.approx(np.array((0.5, 0, 0.2)) * factor)
