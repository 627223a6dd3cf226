"""Derivatives of accelerations against Pinocchio's, which are analytical."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pinocchio
import pytest

from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.inference.linearise import linearised


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
    found = linearised(model, position, velocity, command, every=1)
    for t in range(9):
        exact = analytical(position[t], velocity[t], command[t])
        assert np.allclose(found.acceleration[t], exact[0], rtol=1e-9, atol=1e-9)
        # Rounding of 1e-16 of 100 per s2 over a step of 1e-5, and its square times a derivative.
        assert np.allclose(found.jacobian[t], np.hstack(exact[1:]), rtol=1e-6, atol=1e-6)


def test_derivatives_are_interpolated_between_keys(model: mujoco.MjModel) -> None:
    time = 0.01 * np.arange(11)
    position = np.stack([np.sin(time), np.cos(time)], axis=1)
    velocity = np.stack([np.cos(time), -np.sin(time)], axis=1)
    command = np.zeros((11, 2))
    whole = linearised(model, position, velocity, command, every=1).jacobian
    thin = linearised(model, position, velocity, command, every=4).jacobian
    for key in (0, 4, 8, 10):
        assert np.array_equal(thin[key], whole[key])
    assert np.allclose(thin[5], 0.75 * whole[4] + 0.25 * whole[8], rtol=1e-12, atol=1e-12)
    # A line is off by (h^2 / 8) times the second derivative: 0.04^2 / 8 of it, 2e-4.
    assert np.allclose(thin, whole, atol=1e-3 * np.abs(whole).max())


def test_dry_friction_is_left_out(arm: Callable[..., Robot]) -> None:
    command, still = np.full((3, 2), 0.1), np.zeros((3, 2))
    free = linearised(spec_of(arm()).compile(), still, still, command)
    held = spec_of(arm('frictionloss="5"', 'frictionloss="5"')).compile()
    flags = held.opt.disableflags
    assert np.array_equal(free.acceleration, linearised(held, still, still, command).acceleration)
    assert held.opt.disableflags == flags
