"""Joints in groups and as found."""

from __future__ import annotations

from morph.app.viewer.design.limbs import FEW, found, limbs
from morph.body.load import load
from morph.body.posture import Handle, Posture
from morph.body.robot import Robot
from morph.body.spec import spec_of


def handles_of(robot: Robot) -> tuple[Handle, ...]:
    return Posture(spec_of(robot).compile()).handles


def test_few_joints_are_one_group_without_a_title() -> None:
    robot = load("so101")
    (limb,) = limbs(robot, handles_of(robot))
    assert limb.title == ""
    assert len(limb.handles) == 6


def test_a_humanoid_has_a_trunk_a_head_two_arms_and_two_legs() -> None:
    robot = load("humanoid")
    found_limbs = limbs(robot, handles_of(robot))
    assert [len(limb.handles) for limb in found_limbs] == [5, 2, 4, 4, 5, 5]
    for limb in found_limbs[2:]:
        # By their names: an arm or a leg is of one side.
        assert len({handle.joint[:2] for handle in limb.handles}) == 1


def test_a_long_chain_is_cut_into_pages(long_snake: Robot) -> None:
    pages = limbs(long_snake, handles_of(long_snake))
    assert [len(page.handles) for page in pages] == [12, 12, 12, 12]
    assert pages[1].title == "joint_12 … joint_23 (12)"


def test_every_joint_is_in_one_group() -> None:
    for name in ("humanoid_skateboard", "biped", "quadruped_four_bar", "hexapod_swimmer"):
        robot = load(name)
        handles = handles_of(robot)
        grouped = [handle.joint for limb in limbs(robot, handles) for handle in limb.handles]
        assert sorted(grouped) == sorted(handle.joint for handle in handles)
        assert max(len(limb.handles) for limb in limbs(robot, handles)) <= FEW


def test_no_joints_are_no_groups() -> None:
    assert limbs(load("pendulum"), ()) == ()


def test_a_text_finds_joints_by_their_own_and_by_their_links_names() -> None:
    robot = load("humanoid")
    handles = handles_of(robot)
    assert [handle.joint for handle in found(handles, "KNEE")] == ["l_knee_y", "r_knee_y"]
    assert [handle.joint for handle in found(handles, " knee l_")] == ["l_knee_y"]
    link = next(handle.link for handle in handles if handle.joint == "r_elbow_y")
    assert "r_elbow_y" in [handle.joint for handle in found(handles, link)]
    assert found(handles, "tentacle") == ()
    assert found(handles, "") == handles
