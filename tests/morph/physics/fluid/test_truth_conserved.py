"""What a perfect fluid keeps: Kirchhoff's tumbling, the energy and the impulse of any tree."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.numbers import ADDED, POINT
from morph.physics.fluid.tensor.ellipsoid import ellipsoid_tensor
from morph.sim.simulator import Simulator

Make = Callable[..., Any]
RK4 = mujoco.mjtIntegrator.mjINT_RK4
PUSH, SPIN = (0.7, -0.4, 0.5), (0.8, -1.1, 0.6)
"""Where the tumbling starts, m/s and rad/s."""


def tumbling(whole: Array, seconds: float) -> Array:
    """Return the velocity of a free body and its path, (9,), by DOP853.

    p' = p x w and h' = h x w + p x v for the impulses [p; h] = M [v; w] in its axes (Lamb 1932,
    section 124, eq. 1); the path is the integral of R v, and R' = R [w].
    """
    inverse = np.linalg.inv(whole)

    def rate(_: float, state: Array) -> Array:
        p, h, turned = state[:3], state[3:6], state[6:15].reshape(3, 3)
        v, w = np.split(inverse @ state[:6], 2)
        return np.concatenate(
            [
                np.cross(p, w),
                np.cross(h, w) + np.cross(p, v),
                np.cross(turned, w).ravel(),
                turned @ v,
            ]
        )

    start = np.concatenate([whole @ np.array(PUSH + SPIN), np.eye(3).ravel(), np.zeros(3)])
    end = solve_ivp(rate, (0.0, seconds), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return np.concatenate([inverse @ end[:6], end[15:]])


def tensor_beside_the_middle() -> Array:
    """Return a tensor with every coupling: an ellipsoid of water, turned and moved off."""
    rng = np.random.default_rng(0)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    tensor = ellipsoid_tensor(0.3, 0.2, 0.1).turned(turn).shifted((0.03, -0.02, 0.05))
    return 1000.0 * tensor.matrix


def tumbled(robot: Robot, added: Array, integrator: Any, step: float, seconds: float) -> Array:
    """Return the velocity of a hull in its own axes, and its path, (9,)."""
    simulator = Simulator(robot, (AddedMass.of("hull", added),), step=step)
    simulator.model.opt.integrator = integrator
    speed = {
        f"hull.{which}_velocity.{axis}": value
        for which, three in (("linear", PUSH), ("angular", SPIN))
        for axis, value in zip("xyz", three, strict=True)
    }
    moved = simulator.trajectory(seconds=seconds, speed=speed)
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, moved.position[-1, 3:7])
    ahead = turned.reshape(3, 3).T @ moved.velocity[-1, :3]
    return np.concatenate([ahead, moved.velocity[-1, 3:], moved.position[-1, :3]])


@pytest.mark.parametrize("kind", ["ellipsoid", "coupled"])
def test_a_free_body_tumbles_by_kirchhoffs_equations(
    written: Callable[[str], Robot], kind: str
) -> None:
    mass, spin = 25.0, (0.25, 0.5, 0.65)
    robot = written(
        '<option gravity="0 0 0"/><worldbody><body name="hull"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{mass}" diaginertia="{" ".join(map(str, spin))}"/>'
        "</body></worldbody>"
    )
    added = 1000.0 * ellipsoid_tensor(0.3, 0.2, 0.1).matrix
    if kind == "coupled":
        added = tensor_beside_the_middle()
    whole = np.diag([mass] * 3 + list(spin)) + added
    # It turns at some 2 rad/s: (2 * 0.001)^4 / 120 = 1.3e-13 a radian, 10 radians, and motions
    # that part by Munk's moment grow by exp(1.5 * 5) = 2e3: 3e-9.
    assert tumbled(robot, added, RK4, 0.001, 5.0) == pytest.approx(tumbling(whole, 5.0), abs=3e-9)
    # MuJoCo's implicit step is of the first order: half of the step halves its error, of
    # which less than 2 % is of the second.
    implicit, due = mujoco.mjtIntegrator.mjINT_IMPLICITFAST, tumbling(whole, 1.0)
    coarse, fine = (tumbled(robot, added, implicit, step, 1.0) - due for step in (0.001, 0.0005))
    assert fine == pytest.approx(0.5 * coarse, abs=0.02 * float(np.abs(coarse).max()))


def impulse(model: Any, data: Any) -> Array:
    """Return the impulse of bodies and fluid about the world's origin, linear first, (6,)."""
    total = np.zeros(6)
    for body in range(1, model.nbody):
        turned = data.xmat[body].reshape(3, 3)
        user, jacobian = model.body_user[body], np.zeros((6, model.nv))
        spot = data.xpos[body] + turned @ user[POINT]
        mujoco.mj_jac(model, data, jacobian[:3], jacobian[3:], spot, body)
        added = np.zeros((6, 6))
        added[np.triu_indices(6)] = user[ADDED]
        axes = np.kron(np.eye(2), turned)
        water = axes @ (added + np.triu(added, 1).T) @ axes.T @ jacobian @ data.qvel
        mujoco.mj_jac(model, data, jacobian[:3], jacobian[3:], data.xipos[body], body)
        motion, principal = jacobian @ data.qvel, data.ximat[body].reshape(3, 3)
        spin = principal @ np.diag(model.body_inertia[body]) @ principal.T
        solid = np.concatenate([model.body_mass[body] * motion[:3], spin @ motion[3:]])
        for place, momentum in ((spot, water), (data.xipos[body], solid)):
            total += momentum
            total[3:] += np.cross(place, momentum[:3])
    return total


def drift(model: Any, data: Any, seconds: float) -> tuple[float, float]:
    """Return what a run does to energy and impulse, as parts of what they are."""
    mujoco.mj_forward(model, data)
    energy, first = data.energy[1], impulse(model, data)
    mujoco.mj_step(model, data, round(seconds / model.opt.timestep))
    mujoco.mj_forward(model, data)
    lost = np.abs(impulse(model, data) - first).max() / np.abs(first).max()
    return abs(data.energy[1] / energy - 1.0), float(lost)


@pytest.mark.parametrize(("bodies", "seed"), [(3, 0), (12, 1), (30, 2)])
def test_energy_and_impulse_of_a_tree_are_kept_to_the_fourth_order(
    grown: Make, moving: Make, bodies: int, seed: int
) -> None:
    spec = grown(bodies, seed, ideal=True)
    spec.option.integrator, spec.option.gravity = RK4, (0.0, 0.0, 0.0)
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    model = spec.compile()
    found = []
    for step in (0.005, 0.0025):
        model.opt.timestep = step
        found.append(drift(model, moving(model, seed, 0.3), 2.0))
    # At up to 3 rad/s between two links: (3 * 0.005)^4 / 120 = 4e-10 a radian.
    assert max(found[0]) < 1e-9
    for coarse, fine in zip(*found, strict=True):
        # Half of the step leaves 1/16, or 1/32 where the fourth order cancels; rounding 1e-14.
        assert fine < coarse / 12.0 + 1e-14
