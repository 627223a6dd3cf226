"""How a link moves along a recording, seen in its own axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from morph.arrays import Array, Mask
from morph.physics.body_jacobian import cross_matrix
from morph.physics.dynamics import kinematics


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
        return np.asarray(self.jacobian.transpose(0, 2, 1) @ load)


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
    indices = [model.body(name).id for name in bodies]
    chains = [_chain(model, index) for index in indices]
    seen = kinematics(model, indices, position, velocity)
    axes, rates = seen.axes, seen.rates
    results = {}
    for at, (name, index) in enumerate(zip(bodies, indices, strict=True)):
        turned, origin = seen.turned[:, at], seen.origin[:, at]
        arm = origin - seen.about[:, at]
        jacobian = _about(axes * chains[at][:, None], arm)
        # The rate of the axes, and that of the point about which they turn.
        rate = _about(rates * chains[at][:, None], arm)
        speed = times(jacobian[:, 0], velocity)
        spins = axes[:, :, :3] * chains[at][:, None]
        rate[:, 0] += np.swapaxes(np.cross(spins, speed[:, None]), 1, 2)
        results[name] = _seen(model, index, jacobian, rate, turned, origin, velocity, slope)
    return results


def _chain(model: mujoco.MjModel, body: int) -> Array:
    """Return 1 for each degree of freedom that moves a body, else 0, shape (nv,)."""
    moves = np.zeros(model.nv)
    while body:
        first, count = model.body_dofadr[body], model.body_dofnum[body]
        moves[first : first + count] = 1.0
        body = model.body_parentid[body]
    return moves


def _about(axes: Array, arm: Array) -> Array:
    """Return Jacobians of a point, linear before angular, shape (samples, 2, 3, nv).

    Args:
        axes: MuJoCo's spatial axes, angular before linear, shape (samples, nv, 6).
        arm: The point less the one about which they are, m, shape (samples, 3).
    """
    linear = axes[:, :, 3:] + np.cross(axes[:, :, :3], arm[:, None])
    return np.swapaxes(np.stack([linear, axes[:, :, :3]], axis=1), 2, 3)


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
    parts = (len(velocity), 2, 3)
    flat, moving = (each.reshape(len(velocity), 6, -1) for each in (jacobian, rate))
    twist = times(flat, velocity).reshape(parts)
    change = (times(flat, slope) + times(moving, velocity)).reshape(parts)
    # In the link's axes R' x changes by R' (dx/dt - w x x).
    change -= np.cross(twist[:, 1:], twist)
    inward = np.swapaxes(turned, 1, 2)
    own = inward[:, None] @ jacobian
    axes = np.empty((3, 3))
    mujoco.mju_quat2Mat(axes.reshape(-1), model.body_iquat[index])
    return BodyMotion(
        jacobian=own.reshape(len(velocity), 6, model.nv),
        velocity=(twist @ turned).reshape(-1, 6),
        acceleration=(change @ turned).reshape(-1, 6),
        gravity=inward @ model.opt.gravity,
        origin=origin,
        axes=turned,
        mass=float(model.body_mass[index]),
        com=model.body_ipos[index].copy(),
        inertia=axes @ np.diag(model.body_inertia[index]) @ axes.T,
    )


def times(matrix: Array, vector: Array) -> Array:
    """Return the product at each sample."""
    return np.asarray((matrix @ vector[:, :, None])[:, :, 0])
