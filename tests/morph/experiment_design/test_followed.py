"""Motions of an arm that stands upright, which falls under commands alone; by pinocchio too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.experiment_design.excitation import MARGIN, excitations
from morph.experiment_design.followed import can_follow, follow
from morph.experiment_design.separation import PlannedRun
from morph.sim.simulator import Simulator

LINK = """<link name="{name}"><inertial><origin xyz="0 0 0.15"/><mass value="{mass}"/><inertia
ixx="0.01" iyy="0.012" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="0 0 {up}"/><axis xyz="{axis}"/><limit lower="-2" upper="2.2" effort="{effort}"
velocity="20"/></joint>"""
UPRIGHT = (
    '<robot name="upright"><link name="base"/>'
    + LINK.format(name="turret", mass=1.5)
    + LINK.format(name="upper", mass=1.0)
    + LINK.format(name="fore", mass=0.6)
    + JOINT.format(name="waist", parent="base", child="turret", up=0, axis="0 0 1", effort=9)
    + JOINT.format(name="shoulder", parent="turret", child="upper", up=0.1, axis="0 1 0", effort=14)
    + JOINT.format(name="elbow", parent="upper", child="fore", up=0.3, axis="0 1 0", effort=6)
    + "</robot>"
)
STEP = 0.002


@pytest.fixture
def upright(tmp_path: Path) -> Robot:
    (tmp_path / "upright.urdf").write_text(UPRIGHT)
    return load(tmp_path / "upright.urdf", base="fixed")


def test_what_it_commands_is_the_inverse_dynamics_of_pinocchio(upright: Robot) -> None:
    time = STEP * np.arange(2001)
    turns = np.array([3.0, 2.0, 4.0])
    wanted = 0.8 * (1.0 - np.cos(np.outer(time, turns)))
    most = np.full(3, 50.0)
    made = follow(Simulator(upright, step=STEP), time, wanted, -most, most)
    assert made is not None
    joints = ("waist", "shoulder", "elbow")
    moved = np.stack([made[f"{name}.position"] for name in joints], axis=1)
    # Feedback leaves what a step is late: h a / (2 w) of 12 rad/s, 1 ms of 10 rad/s2.
    assert np.abs(moved - wanted).max() < 2e-3
    model = pinocchio.buildModelFromXML(UPRIGHT)
    data = model.createData()
    told = np.stack([made[f"{name}.command"] for name in (a.name for a in upright.actuators)], 1)
    speed = 0.8 * turns * np.sin(np.outer(time, turns))
    pull = 0.8 * turns**2 * np.cos(np.outer(time, turns))
    due = [pinocchio.rnea(model, data, *at) for at in zip(wanted, speed, pull, strict=True)]
    # Half a step late at 4 rad/s and twice that for Coriolis forces: 1 % of the torque.
    error = np.sqrt(np.mean((told - np.array(due)[:-1]) ** 2, axis=0))
    assert (error < 0.02 * np.sqrt(np.mean(np.array(due) ** 2, axis=0))).all()


def test_an_arm_that_falls_is_given_positions_to_follow(upright: Robot) -> None:
    made = excitations(upright, 6.0, STEP, 0)
    assert {each.kind for each in made} >= {"follow: quick", "follow: slow"}
    led = [each for each in made if each.references]
    for each in led:
        for joint in upright.joints:
            low, high = joint.limits or (0.0, 0.0)
            room = MARGIN * (high - low)
            seen = each.recording[f"{joint.name}.position"]
            assert np.ptp(seen) > 0.3
            assert low + room <= seen.min()
            assert seen.max() <= high - room
    told = PlannedRun(excitation=led[0], seconds=5.0).inputs.channels
    assert set(told) == {
        f"{name}.{what}"
        for names, what in (
            ([joint.name for joint in upright.joints], "position"),
            ([actuator.name for actuator in upright.actuators], "command"),
        )
        for name in names
    }
    assert all(4.9 < channel.time[-1] < 5.0 for channel in told.values())


@pytest.mark.parametrize("weak", [0.02, 1.0])
def test_what_its_motors_cannot_do_is_not_planned(upright: Robot, weak: float) -> None:
    time = STEP * np.arange(1001)
    wanted = np.stack([np.zeros(1001), 1.5 * np.minimum(time, 1.0), np.zeros(1001)], axis=1)
    most = weak * np.array([9.0, 14.0, 6.0])
    made = follow(Simulator(upright, step=STEP), time, wanted, -most, most)
    # The shoulder holds 9.81 (1.0 0.15 + 0.6 0.45) = 4.1 N m at most.
    assert (made is None) == (weak < 0.2)


@pytest.mark.parametrize(
    ("body", "can"), [("double_pendulum", True), ("cartpole", False), ("so101", False)]
)
def test_each_joint_needs_a_motor_of_its_own(body: str, can: bool) -> None:
    assert can_follow(load(body)) == can
