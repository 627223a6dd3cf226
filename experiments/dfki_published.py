"""What the publisher of the double pendulum states of it, friction included."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from experiments.openloop import Model, from_mjcf
from morph.arrays import Array
from morph.body.fulltext import fulltext
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.model.segments import Segments

STEEPNESS = 100.0
"""Of the arctangent in the published law of friction, s/rad."""
SUBSTEPS = 8
"""Of Runge and Kutta's method a step of the grid: 0.5 ms where friction turns within 10 ms."""


@dataclass(frozen=True, kw_only=True)
class Published:
    """Parameters of one design as DFKI's repository states them.

    Source: github.com/dfki-ric-underactuated-lab/double_pendulum,
    data/system_identification/identified_parameters/<design>/model_parameters.yml. Friction was
    not fitted with the rest: `cf1`, `cf2`, `b1` and `b2` are held fixed at the same four
    numbers for both designs (src/python/examples, `fix_friction = True`).
    """

    mass: tuple[float, float]
    """Mass of each link, kg."""
    length: float
    """Length of the first link, m."""
    centre: tuple[float, float]
    """Distance of each link's centre of mass from its joint, m."""
    inertia: tuple[float, float]
    """Inertia of each link about its joint, kg m2."""
    rotor: float
    """Inertia of each motor's rotor, kg m2."""
    gear: float = 6.0
    """Gear ratio."""
    gravity: float = 9.81
    """m/s2."""
    coulomb: tuple[float, float] = (0.093, 0.078)
    """Factor of the arctangent at each joint, N m; not the level of friction (`level`)."""
    viscous: float = 0.001
    """Damping of each joint, N m s/rad."""

    @property
    def level(self) -> tuple[float, float]:
        """Return the friction of each joint in motion, N m.

        The publisher's equation of motion (src/python/double_pendulum/model/plant.py) has
        b v + cf arctan(100 v), which tends to b v + cf pi / 2.
        """
        return 0.5 * math.pi * self.coulomb[0], 0.5 * math.pi * self.coulomb[1]


PUBLISHED = {
    # design_C.0/model_3.0 at 33b5db8
    "C.0": Published(
        mass=(0.6416936775868083, 0.5639360564500752),
        length=0.2,
        centre=(0.2, 0.32126693265850237),
        inertia=(0.026710760905753486, 0.05387812962959988),
        rotor=9.937281204851094e-05,
    ),
    # design_A.0/model_2.0 at a3fad8b
    "A.0": Published(
        mass=(0.5593806151425046, 0.6043459469186889),
        length=0.3,
        centre=(0.3, 0.18377686083653508),
        inertia=(0.053470810264216295, 0.02392374528789766),
        rotor=7.659297952841183e-05,
    ),
}
"""Each design by its name."""


def with_friction(robot: Robot, level: tuple[float, float], viscous: float) -> Model:
    """Return the described robot with Coulomb friction, N m, and damping, N m s/rad, added."""
    spec = spec_of(robot)
    for joint, friction in zip(robot.joints, level, strict=True):
        at = spec.joint(joint.name)
        at.frictionloss = friction
        damping = np.array(at.damping, dtype=float)
        np.ravel(damping)[0] = viscous
        at.damping = damping
    spec.compile()
    return Model(robot=from_mjcf(fulltext(spec)))


def acceleration(rig: Published, q: Array, v: Array, torque: Array) -> Array:
    """Return the joints' accelerations by the publisher's equations, rad/s2, (rows, 2).

    Source: plant.py of the same repository: M(q) a = G(q) + u - C(q, v) v - F(v), with

        M11 = I1 + I2 + m2 l1^2 + 2 m2 l1 r2 cos q2 + n^2 Ir + Ir
        M12 = I2 + m2 l1 r2 cos q2 - n Ir
        M22 = I2 + n^2 Ir
        F = b v + cf arctan(100 v)

    Args:
        rig: Its parameters.
        q: Angles, of the second joint relative to the first link, rad, (rows, 2).
        v: Velocities, rad/s, same shape.
        torque: At the joints, N m, same shape.
    """
    (m1, m2), (r1, r2), (i1, i2) = rig.mass, rig.centre, rig.inertia
    l1, n, g = rig.length, rig.gear, rig.gravity
    coupling = m2 * l1 * r2
    cosine, sine = np.cos(q[:, 1]), np.sin(q[:, 1])
    m11 = i1 + i2 + m2 * l1**2 + 2.0 * coupling * cosine + (n**2 + 1.0) * rig.rotor
    m12 = i2 + coupling * cosine - n * rig.rotor
    m22 = i2 + n**2 * rig.rotor
    weight2 = -m2 * g * r2 * np.sin(q.sum(axis=1))
    weight1 = -(m1 * r1 + m2 * l1) * g * np.sin(q[:, 0]) + weight2
    friction = rig.viscous * v + np.array(rig.coulomb) * np.arctan(STEEPNESS * v)
    force1 = torque[:, 0] + weight1 + coupling * sine * v[:, 1] * (2.0 * v[:, 0] + v[:, 1])
    force2 = torque[:, 1] + weight2 - coupling * sine * v[:, 0] ** 2
    force1, force2 = force1 - friction[:, 0], force2 - friction[:, 1]
    determinant = m11 * m22 - m12**2
    return np.stack(
        [
            (m22 * force1 - m12 * force2) / determinant,
            (m11 * force2 - m12 * force1) / determinant,
        ],
        axis=1,
    )


def by_its_equations(rig: Published, segments: Segments) -> Array:
    """Return what the publisher's model predicts, (segments, readings, 2), started as measured.

    Runge and Kutta's fourth-order method, commands held over each step of the grid.
    """
    commands = segments.command([episode.command for episode in segments.episodes])
    q, v = segments.start[:, :2].copy(), segments.start[:, 2:].copy()
    path = [q]
    h = segments.step / SUBSTEPS
    for torque in np.moveaxis(commands, 1, 0):
        for _ in range(SUBSTEPS):
            a1 = acceleration(rig, q, v, torque)
            v2 = v + 0.5 * h * a1
            a2 = acceleration(rig, q + 0.5 * h * v, v2, torque)
            v3 = v + 0.5 * h * a2
            a3 = acceleration(rig, q + 0.5 * h * v2, v3, torque)
            v4 = v + h * a3
            a4 = acceleration(rig, q + h * v3, v4, torque)
            q = q + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        path.append(q)
    at = np.stack(path, axis=1)
    rows = np.arange(len(segments))[:, None]
    before, after = at[rows, segments.before], at[rows, segments.before + 1]
    return np.asarray(before + segments.part[..., None] * (after - before))
