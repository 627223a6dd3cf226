"""MuJoCo against Pinocchio: two parsers and two sets of algorithms."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pinocchio
import pytest

from morph.arrays import Array
from morph.body import shelf
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.body.twin import twin_of
from morph.errors import RobotError

# Pinocchio counts a free joint's velocities in other axes, and makes one joint of several
# on one body; test_shelf_bodies.py holds those bodies against it too.
PLAIN = [
    name
    for name in shelf.names()
    if len({joint.link for joint in load(name).joints}) == len(load(name).joints)
    and all(joint.kind in ("hinge", "slide") for joint in load(name).joints)
]

# Both use doubles; forces here are at most about 100 N m, so rounding is 1e-13.
TOLERANCE = 1e-9


def states(model: Any) -> list[tuple[Array, Array, Array]]:
    """Return ten random positions, velocities and accelerations."""
    rng = np.random.default_rng(7)
    return [tuple(rng.normal(size=(3, model.nv))) for _ in range(10)]


@pytest.mark.parametrize("name", PLAIN)
def test_both_have_the_same_joints(name: str) -> None:
    robot = load(name)
    assert list(twin_of(robot).names)[1:] == [joint.name for joint in robot.joints]


@pytest.mark.parametrize("name", PLAIN)
def test_both_have_the_same_mass_matrix_and_bias(name: str) -> None:
    model, twin = spec_of(load(name)).compile(), twin_of(load(name))
    data, notes = mujoco.MjData(model), twin.createData()
    full = np.zeros((model.nv, model.nv))
    for position, velocity, _ in states(model):
        data.qpos[:], data.qvel[:] = position, velocity
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, full)
        upper = np.triu(pinocchio.crba(twin, notes, position))
        assert np.abs(upper - np.triu(full)).max() < TOLERANCE
        bias = pinocchio.nonLinearEffects(twin, notes, position, velocity)
        assert np.abs(bias - data.qfrc_bias).max() < TOLERANCE


@pytest.mark.parametrize("name", PLAIN)
def test_both_need_the_same_torque_for_the_same_motion(name: str) -> None:
    spec = spec_of(load(name))
    # Pinocchio knows neither damping nor the stops of a joint.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_DAMPER
    model, twin = spec.compile(), twin_of(load(name))
    data, notes = mujoco.MjData(model), twin.createData()
    for position, velocity, acceleration in states(model):
        data.qpos[:], data.qvel[:], data.qacc[:] = position, velocity, acceleration
        mujoco.mj_inverse(model, data)
        torque = pinocchio.rnea(twin, notes, position, velocity, acceleration)
        assert np.abs(torque - data.qfrc_inverse).max() < TOLERANCE


def test_what_pinocchio_cannot_read_is_refused() -> None:
    robot = Robot(name="odd", links=(), joints=(), actuators=(), mjcf="<mujoco><worldbody>")
    with pytest.raises(RobotError, match="Pinocchio cannot read it"):
        twin_of(robot)
