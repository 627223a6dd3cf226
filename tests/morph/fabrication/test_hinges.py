"""Joints as print sees them, against MuJoCo and the closed form of a four-bar."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from morph.body.load import load
from morph.body.spec import bare_spec
from morph.fabrication.drawing import drawing
from morph.fabrication.hinges import hinges


@pytest.mark.parametrize("name", ["so101", "quadruped_printed", "humanoid", "quadruped_four_bar"])
def test_axes_are_those_of_mujoco_with_all_joints_at_zero(name: str) -> None:
    robot = load(name)
    model = bare_spec(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found = {hinge.name: hinge for hinge in hinges(drawing(robot))}
    parents = {link.name: link.parent for link in robot.links}
    between = [j for j in robot.joints if j.kind == "hinge" and parents[j.link] in parents]
    assert list(found) == [joint.name for joint in between]
    for joint in between:
        at = model.joint(joint.name).id
        hinge = found[joint.name]
        assert hinge.axis == pytest.approx(data.xaxis[at], abs=1e-12)
        assert hinge.position == pytest.approx(1e3 * data.xanchor[at], abs=1e-9)
        assert (hinge.still, hinge.moving) == (parents[joint.link], joint.link)
        if joint.limits is not None:
            assert (hinge.low, hinge.high) == joint.limits


def test_what_hangs_from_the_world_has_no_hinge() -> None:
    assert [hinge.name for hinge in hinges(drawing(load("cartpole")))] == ["hinge"]


def test_a_rider_that_stands_free_on_a_board_has_no_hinge_with_it() -> None:
    found = {hinge.moving for hinge in hinges(drawing(load("humanoid_skateboard")))}
    assert "pelvis" not in found
    assert {"waist", "front_left_wheel"} <= found


def test_a_joint_without_limits_turns_all_the_way_round_outside_a_closed_chain() -> None:
    hinge = hinges(drawing(load("cartpole")))[0]
    assert (hinge.low, hinge.high) == (-math.pi, math.pi)


def test_the_thigh_of_a_four_bar_turns_as_far_as_its_crank_drives_it() -> None:
    from morph.body.four_bar import FourBar

    # The drawing as its card states it: outward and up from the core, m.
    servo, hip = np.array([0.058, 0.010]), np.array([0.095, 0.0])
    crank, lever = np.array([0.058, 0.030]), np.array([0.091, 0.034])
    bar = FourBar.of(servo, crank, lever, hip)
    ground = math.atan2(*(hip - servo)[::-1])
    home = math.atan2(*(crank - servo)[::-1]) - ground
    rocker = [float(bar.rocker_angle(home + turn)) for turn in (-0.8, 0.0, 0.8)]
    wanted = sorted(angle - rocker[1] for angle in (rocker[0], rocker[2]))
    found = {hinge.name: hinge for hinge in hinges(drawing(load("quadruped_four_bar")))}
    # 3 degrees are added on each side, as corners are not all there is.
    margin = math.radians(3.0)
    for leg in ("front_left", "rear_right"):
        thigh = found[f"{leg}_hip"]
        assert [thigh.low + margin, thigh.high - margin] == pytest.approx(wanted, abs=1e-5)
