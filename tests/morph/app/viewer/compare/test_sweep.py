"""Joints through their ranges: as far as they go, what follows them, and nothing torn."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from morph.app.viewer.compare.body_show import sweeps
from morph.app.viewer.compare.figures import MARGIN
from morph.app.viewer.compare.sweep import swept
from morph.body.load import load
from morph.body.posture import Posture
from morph.body.robot import Robot
from morph.sim.simulator import Simulator

ARM = """<body name="arm"><joint name="arm" axis="0 1 0" range="-90 30"/>
<geom type="box" size="0.01 0.01 0.25" pos="0 0 0.25" mass="2" contype="0" conaffinity="0"/>
<body name="hand" pos="0 0 0.5"><joint name="hand" type="slide" axis="0 0 1" range="-0.1 0.2"/>
<geom type="sphere" size="0.01" mass="0.000001" contype="0" conaffinity="0"/>
</body></body>"""
MOTOR = '<motor name="arm" joint="arm" ctrllimited="true" ctrlrange="-19.62 19.62"/>'


def posture(robot: Robot) -> Posture:
    return Posture(Simulator(robot).model)


def test_every_joint_goes_to_both_its_ends_and_comes_home(made: Callable[..., Robot]) -> None:
    poses, whole = swept(posture(made(ARM, MOTOR)))
    assert whole
    assert poses.shape == (301, 2)
    np.testing.assert_allclose(poses.min(axis=0), [-np.pi / 2.0, -0.1], atol=1e-3)
    np.testing.assert_allclose(poses.max(axis=0), [np.pi / 6.0, 0.2], atol=1e-3)
    np.testing.assert_allclose(poses[[0, -1]], 0.0, atol=1e-9)
    # Two joints in 5 s: each has its half to itself.
    assert np.abs(poses[151:, 0]).max() < 1e-9
    assert np.abs(poses[:150, 1]).max() < 1e-9


def test_it_takes_as_long_as_is_asked_for(made: Callable[..., Robot]) -> None:
    assert len(swept(posture(made(ARM, MOTOR)), 2.0)[0]) == 121


@pytest.mark.parametrize("name", ["biped", "hopper", "cartpole", "rider_rigid_passive"])
def test_what_only_lets_a_body_float_in_a_plane_is_not_swept(name: str) -> None:
    held = posture(load(name))
    poses, _ = swept(held)
    moved = {
        handle.joint
        for place, handle in zip(held.places, held.handles, strict=True)
        if np.ptp(poses[:, place]) > 1e-9
    }
    # By hand, from the descriptions: root_x, root_z and root_pitch; forward, up and pitch.
    left = {"biped": 3, "hopper": 3}.get(name, 0)
    assert len(held.handles) - len(moved) == left
    assert not {"root_x", "root_z", "root_pitch", "forward", "up", "pitch"} & moved


def test_many_joints_overlap_but_each_has_its_ends() -> None:
    held = posture(load("humanoid"))
    poses, _ = swept(held)
    for place, handle in zip(held.places, held.handles, strict=True):
        assert poses[:, place].max() == pytest.approx(handle.high, abs=0.03)
        assert poses[:, place].min() == pytest.approx(handle.low, abs=0.03)


def test_closed_chains_stay_closed_and_what_nothing_drives_follows() -> None:
    held = posture(load("quadruped_four_bar"))
    poses, _ = swept(held, 1.0)
    model, data = held.model, mujoco.MjData(held.model)
    for pose in poses[::5]:
        data.qpos[:] = pose
        mujoco.mj_fwdPosition(model, data)
        # MuJoCo's own measure of how far apart the ends of each pin are, m.
        assert np.abs(data.efc_pos[: data.ne]).max() < 2e-6
    moved = np.ptp(poses, axis=0)[held.model.jnt_qposadr[held.model.jnt_type != 0]]
    assert (moved > 1e-3).all()


def test_a_joint_that_follows_another_follows_it_here(made: Callable[..., Robot]) -> None:
    both = ARM.replace('range="-0.1 0.2"', 'range="-3 3"')
    rest = '<equality><joint joint1="hand" joint2="arm" polycoef="0 0.5 0 0 0"/></equality>'
    poses, _ = swept(posture(made(both, MOTOR, rest)))
    np.testing.assert_allclose(poses[:, 1], 0.5 * poses[:, 0], atol=2e-6)
    assert np.ptp(poses[:, 0]) > 2.0


def test_the_holding_margin_is_that_of_the_worst_pose_so_far(made: Callable[..., Robot]) -> None:
    show = sweeps(made(ARM, MOTOR), "arm", surroundings=None, seconds=None)
    # 2 kg at 0.25 m: 2 * 9.81 * 0.25 sin(angle) = 4.905 N m at a quarter turn, of 19.62 N m.
    left = show.motion.series[MARGIN]
    assert left[0] == pytest.approx(100.0)
    assert left[-1] == pytest.approx(75.0, abs=0.01)
    assert show.felt is None


def test_a_body_without_joints_stands(made: Callable[..., Robot]) -> None:
    robot = made('<body name="stone"><geom type="sphere" size="0.1"/></body>')
    show = sweeps(robot, "stone", surroundings=None, seconds=1.0)
    assert show.motion.pictures == 61
    assert np.ptp(show.motion.position, axis=0).max() == 0.0
    assert np.isnan(show.motion.series[MARGIN]).all()


def test_a_cart_on_an_endless_slide_stays_on_its_rail() -> None:
    poses, _ = swept(posture(load("cartpole")))
    # The rail of the description ends 1.5 m to either side, and the cart is 0.16 m long.
    assert 1.0 < np.abs(poses[:, 0]).max() < 1.5 - 0.08
