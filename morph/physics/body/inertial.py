"""The force of a link's mass, first moment and inertia along a recording."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.physics.body_jacobian import cross_matrix
from morph.physics.body_motion import BodyMotion


def spatial(mass: float, moment: Array, second: Array) -> Array:
    """Return the inertia K of a link about its origin, [momentum; spin] = K [v; w].

    Source: Featherstone 2008, Rigid Body Dynamics Algorithms, eq. 2.63.

    Args:
        mass: kg.
        moment: Mass times the centre of mass, kg m, shape (3,).
        second: Moment of inertia about the origin, kg m2, shape (3, 3).
    """
    whole = np.zeros((6, 6))
    whole[:3, :3] = mass * np.eye(3)
    whole[3:, :3], whole[:3, 3:] = cross_matrix(moment), -cross_matrix(moment)
    whole[3:, 3:] = second
    return whole


def pull(body: BodyMotion, inertias: list[Array]) -> Array:
    """Return the generalized force of what each of some inertias adds to a link.

    With [p; h] = K [v; w]: F = m g - (dp/dt + w x p), T = c x m g - (dh/dt + w x h + v x p).
    It is linear in K, hence in mass, first moment and moment of inertia about the origin.

    Source: Atkeson, An and Hollerbach 1986, Int. J. Robotics Research 5(3), eqs. 5 to 8.

    Args:
        body: How the link moves.
        inertias: K of each, shape (6, 6).

    Returns:
        Shape (samples, degrees of freedom, inertias).
    """
    moving, turning = (cross_matrix(body.velocity[:, part]) for part in (slice(3), slice(3, 6)))
    # Gravity is an acceleration of the frame; it turns with the link and adds no spin.
    felt = body.acceleration.copy()
    felt[:, :3] -= body.gravity
    inertia = np.stack(inertias)
    momentum, rate = (
        np.moveaxis(np.tensordot(each, inertia, axes=(1, 2)), 1, 2)
        for each in (body.velocity, felt)
    )
    p, h = momentum[:, :3], momentum[:, 3:]
    load = -rate
    load[:, :3] -= turning @ p
    load[:, 3:] -= turning @ h + moving @ p
    return body.forces(load)


def steiner(one: Array, other: Array) -> Array:
    """Return what the product of two places is to a moment of inertia, (a.b) 1 - (a b' + b a') / 2.

    With both the same place it is Steiner's theorem for one kilogram.
    """
    product = 0.5 * (np.outer(one, other) + np.outer(other, one))
    return np.asarray(one @ other * np.eye(3) - product)
