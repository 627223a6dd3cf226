"""Dynamics along a motion against Pinocchio's, and against MuJoCo called state by state."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pinocchio
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.physics.dynamics import accelerations, jacobians, kinematics, supplied
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.linear_drag import LinearDrag
from morph.sim.simulator import compiled


@pytest.fixture
def model(arm: Callable[..., Robot]) -> mujoco.MjModel:
    """The arm with two links, with damped joints."""
    return spec_of(arm('damping="0.3"', 'damping="0.1"')).compile()


def analytical(
    position: np.ndarray, velocity: np.ndarray, force: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Return accelerations and derivatives of the same arm, built anew joint by joint."""
    robot = pinocchio.Model()
    about = pinocchio.JointModelRY()
    upper = robot.addJoint(0, about, pinocchio.SE3(np.eye(3), np.array([0.0, 0.0, 1.0])), "a")
    spin = 0.01 * np.eye(3)
    robot.appendBodyToJoint(
        upper, pinocchio.Inertia(2.0, np.array([0.2, 0.0, 0.0]), spin), pinocchio.SE3.Identity()
    )
    lower = robot.addJoint(upper, about, pinocchio.SE3(np.eye(3), np.array([0.4, 0.0, 0.0])), "b")
    robot.appendBodyToJoint(
        lower, pinocchio.Inertia(1.0, np.array([0.1, 0.0, 0.0]), spin), pinocchio.SE3.Identity()
    )
    data = robot.createData()
    damping = np.array([0.3, 0.1])
    pinocchio.computeABADerivatives(robot, data, position, velocity, force - damping * velocity)
    inverse = np.triu(data.Minv) + np.triu(data.Minv, 1).T
    return data.ddq.copy(), data.ddq_dq.copy(), data.ddq_dv - inverse * damping, inverse


def test_derivatives_are_those_of_another_library(model: mujoco.MjModel) -> None:
    rng = np.random.default_rng(0)
    position, velocity = rng.uniform(-2.0, 2.0, (2, 9, 2))
    command = rng.uniform(-4.0, 4.0, (9, 2))
    found = accelerations(model, position, velocity, command)
    derivatives = jacobians(model, position, velocity, command)
    for t in range(9):
        exact = analytical(position[t], velocity[t], command[t])
        assert np.allclose(found[t], exact[0], rtol=1e-9, atol=1e-9)
        # Rounding of 1e-16 of 100 per s2 over a step of 1e-5, and its square times a derivative.
        assert np.allclose(derivatives[t], np.hstack(exact[1:]), rtol=1e-6, atol=1e-6)


def test_forces_are_those_of_another_library(model: mujoco.MjModel) -> None:
    rng = np.random.default_rng(1)
    position, velocity, slope, command = rng.uniform(-2.0, 2.0, (4, 9, 2))
    found = supplied(model, position, velocity, slope, command)
    for t in range(9):
        motion, _, _, inverse = analytical(position[t], velocity[t], command[t])
        # M (a(u) - a) is what is supplied beyond the need of a.
        exact = np.linalg.solve(inverse, motion - slope[t])
        assert np.allclose(found[t], exact, rtol=1e-9, atol=1e-9)


def test_kinematics_are_those_of_the_engine(model: mujoco.MjModel) -> None:
    rng = np.random.default_rng(2)
    position, velocity = rng.uniform(-2.0, 2.0, (2, 5, 2))
    bodies, data = [2, 1], mujoco.MjData(model)
    found = kinematics(model, bodies, position, velocity)
    for t in range(5):
        data.qpos[:], data.qvel[:] = position[t], velocity[t]
        mujoco.mj_forward(model, data)
        assert np.array_equal(found.origin[t], data.xpos[bodies])
        assert np.array_equal(found.turned[t].reshape(2, 9), data.xmat[bodies])
        assert np.array_equal(found.axes[t], data.cdof)
        assert np.array_equal(found.rates[t], data.cdof_dot)
        assert np.array_equal(found.about[t], data.subtree_com[model.body_rootid[bodies]])


def test_dry_friction_is_left_out(arm: Callable[..., Robot]) -> None:
    command, still = np.full((3, 2), 0.1), np.zeros((3, 2))
    free = accelerations(spec_of(arm()).compile(), still, still, command)
    held = spec_of(arm('frictionloss="5"', 'frictionloss="5"')).compile()
    flags = held.opt.disableflags
    assert np.array_equal(free, accelerations(held, still, still, command))
    assert held.opt.disableflags == flags


def test_derivatives_of_a_robot_in_water_are_those_of_its_accelerations() -> None:
    robot = load("swimmer_three_links")
    effects = (LinearDrag(body="tail", y=20.0), AddedMass(body="tail", y=0.3))
    wet = compiled(spec_of(robot), effects, robot).model
    rng = np.random.default_rng(3)
    position, velocity = rng.uniform(-1.0, 1.0, (2, 3, wet.nv))
    command = np.zeros((3, wet.nu))
    found = jacobians(wet, position, velocity, command)
    for axis in range(wet.nv):
        for block, (dq, dv) in enumerate(((1e-6, 0.0), (0.0, 1e-6))):
            q, v = (np.eye(wet.nv)[axis] * each for each in (dq, dv))
            above = accelerations(wet, position + q, velocity + v, command)
            below = accelerations(wet, position - q, velocity - v, command)
            slope = (above - below) / 2e-6
            # Accelerations near 1e3 round to 1e-13, over 2e-6: 1e-7; and truncation.
            assert np.allclose(found[:, :, block * wet.nv + axis], slope, rtol=1e-4, atol=1e-4)
