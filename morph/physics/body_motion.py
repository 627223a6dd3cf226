"""How a link moves along a recording, seen in its own axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from morph.arrays import Array, Mask


@dataclass(frozen=True, kw_only=True)
class BodyMotion:
    """Velocity, acceleration and gravity of one link, linear before angular, in its axes."""

    jacobian: Array
    """Of the link's origin, shape (samples, 6, degrees of freedom)."""
    velocity: Array
    """m/s and rad/s, shape (samples, 6)."""
    acceleration: Array
    """How those change: the rate of the components, m/s2 and rad/s2, shape (samples, 6)."""
    gravity: Array
    """m/s2, shape (samples, 3)."""
    origin: Array
    """The link's origin in the world, m, shape (samples, 3)."""
    axes: Array
    """The link's axes in the world as columns, shape (samples, 3, 3)."""
    mass: float
    """Mass of the link, kg."""
    com: Array
    """Its centre of mass in its frame, m, shape (3,)."""
    inertia: Array
    """About its centre of mass in its axes, kg m2, shape (3, 3)."""

    def within(self, chosen: Mask) -> BodyMotion:
        """Return the chosen samples."""
        return replace(
            self,
            jacobian=self.jacobian[chosen],
            velocity=self.velocity[chosen],
            acceleration=self.acceleration[chosen],
            gravity=self.gravity[chosen],
            origin=self.origin[chosen],
            axes=self.axes[chosen],
        )

    def pulled(self, force: Array, point: Array) -> Array:
        """Return what forces at a point of the link do to the joints, (samples, dofs, columns).

        Args:
            force: Along the axes of the world, N, shape (samples, 3, columns).
            point: In the link's frame, m, shape (3,).
        """
        own = np.einsum("sji,sjc->sic", self.axes, force)
        turn = np.einsum("ij,sjc->sic", cross_matrix(point), own)
        return self.forces(np.concatenate([own, turn], axis=1))

    def forces(self, load: Array) -> Array:
        """Return loads (samples, 6, columns) as joint forces, (samples, dofs, columns)."""
        return np.asarray(np.einsum("sid,sic->sdc", self.jacobian, load))


def body_motions(
    model: mujoco.MjModel, bodies: Sequence[str], position: Array, velocity: Array, slope: Array
) -> dict[str, BodyMotion]:
    """Return how links move through states of a model.

    Args:
        model: The compiled robot.
        bodies: Names of links.
        position: Generalized positions, shape (samples, nq).
        velocity: Generalized velocities, shape (samples, nv).
        slope: Generalized accelerations, shape (samples, nv).
    """
    data = mujoco.MjData(model)
    samples, indices = len(velocity), [model.body(name).id for name in bodies]
    jacobian, rate = np.zeros((2, len(indices), samples, 2, 3, model.nv))
    turned, origin = np.empty((len(indices), samples, 3, 3)), np.empty((len(indices), samples, 3))
    for k in range(samples):
        data.qpos[:], data.qvel[:] = position[k], velocity[k]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        for at, index in enumerate(indices):
            spot, here, change = data.xpos[index], jacobian[at, k], rate[at, k]
            mujoco.mj_jac(model, data, here[0], here[1], spot, index)
            mujoco.mj_jacDot(model, data, change[0], change[1], spot, index)
            turned[at, k], origin[at, k] = data.xmat[index].reshape(3, 3), spot
    return {
        name: _seen(model, index, jacobian[at], rate[at], turned[at], origin[at], velocity, slope)
        for at, (name, index) in enumerate(zip(bodies, indices, strict=True))
    }


def _seen(
    model: mujoco.MjModel,
    index: int,
    jacobian: Array,
    rate: Array,
    turned: Array,
    origin: Array,
    velocity: Array,
    slope: Array,
) -> BodyMotion:
    """Return the motion of one link in its own axes.

    Args:
        model: The compiled robot.
        index: The link's.
        jacobian: In the world's axes, shape (samples, 2, 3, nv).
        rate: How that changes, likewise.
        turned: The link's axes as columns, shape (samples, 3, 3).
        origin: The link's origin in the world, shape (samples, 3).
        velocity: Generalized velocities, shape (samples, nv).
        slope: Generalized accelerations, shape (samples, nv).
    """
    twist = np.einsum("srid,sd->sri", jacobian, velocity)
    change = np.einsum("srid,sd->sri", jacobian, slope)
    change += np.einsum("srid,sd->sri", rate, velocity)
    # In the link's axes R' x changes by R' (dx/dt - w x x).
    change -= np.cross(twist[:, 1:], twist)
    own = np.einsum("sji,srjd->srid", turned, jacobian)
    flat = np.empty(9)
    mujoco.mju_quat2Mat(flat, model.body_iquat[index])
    axes = flat.reshape(3, 3)
    return BodyMotion(
        jacobian=own.reshape(len(velocity), 6, model.nv),
        velocity=np.einsum("sji,srj->sri", turned, twist).reshape(-1, 6),
        acceleration=np.einsum("sji,srj->sri", turned, change).reshape(-1, 6),
        gravity=np.einsum("sji,j->si", turned, model.opt.gravity),
        origin=origin,
        axes=turned,
        mass=float(model.body_mass[index]),
        com=model.body_ipos[index].copy(),
        inertia=axes @ np.diag(model.body_inertia[index]) @ axes.T,
    )


def jacobian_of(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, point: Array
) -> tuple[Array, Array]:
    """Return J and dJ/dt of a point of a body, in the body's axes, linear rows first.

    Args:
        model: The compiled robot.
        data: Its state, positions and velocities passed forward.
        body: The body's index.
        point: The point in the body's frame, m.

    Returns:
        Two matrices of shape (6, nv): J v are the components of the velocity, and their
        rate is J dv/dt + dJ/dt v.
    """
    turned = data.xmat[body].reshape(3, 3)
    spot = data.xpos[body] + turned @ point
    linear, angular = np.zeros((2, 3, model.nv))
    mujoco.mj_jac(model, data, linear, angular, spot, body)
    linear_rate, angular_rate = np.zeros((2, 3, model.nv))
    mujoco.mj_jacDot(model, data, linear_rate, angular_rate, spot, body)
    # In the body's axes R' x changes by R' (dx/dt - w x x).
    spin = cross_matrix(angular @ data.qvel)
    jacobian = np.vstack([turned.T @ linear, turned.T @ angular])
    rate = np.vstack(
        [turned.T @ (linear_rate - spin @ linear), turned.T @ (angular_rate - spin @ angular)]
    )
    return jacobian, rate


def cross_matrix(x: Array) -> Array:
    """Return the matrix (3, 3) that multiplies by x from the left as the cross product does."""
    return np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])
