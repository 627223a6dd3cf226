"""The swimmer's water, by the coefficients that are published for AQUA."""

from __future__ import annotations

import math

from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.physics.fluid.box import boxed
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.thrust import Thrust

DENSITY = 1000.0
"""Fresh water, kg/m3."""

HULL = (0.64, 0.21, 0.12)
"""Length, width and height of the hull's box, m: AQUA's Gazebo description, as the card has it."""

HULL_ADDED = (6.98, 14.5, 32.41, 0.4, 1.19, 0.55)
"""Added mass of the hull along its axes, kg, and about them, kg m2.

Source: Georgiades 2005, Simulation and control of an underwater hexapod robot, McGill University.
"""

HULL_DRAG = (0.9, 1.08, 1.28)
"""Drag coefficients of the hull along its axes; the same source."""

PADDLE = (0.16, 0.05, 0.003)
"""Length, width and thickness of a paddle, m."""

PADDLE_DRAG = (0.0, 0.0, 1.12)
"""Drag coefficients of a paddle along its axes; the same source. Along the blade there is none."""

PADDLE_MIDDLE = -0.088
"""The blade's middle, behind the hip, m."""

SHORTER = 0.84
"""What the ends take from the added mass of a strip that is 3.2 times as long as wide.

Source: DNV-RP-H103 2011, Modelling and analysis of marine operations, table A-2: 0.840 at 3.17.
"""


def aqua_water(robot: Robot, *, thrust: float = 1.0, drag: bool = True) -> tuple[Effect, ...]:
    """Return what fresh water does to the hexapod swimmer.

    Args:
        robot: The swimmer.
        thrust: Share of Lighthill's force at the end of each paddle; 0 for none.
        drag: Whether there is any; without it and without thrust the water is a perfect fluid.
    """
    blades = [link.name for link in robot.links if link.name != "hull"]
    blade = math.prod(PADDLE)
    rest = robot.mass / DENSITY - len(blades) * blade
    effects = list(
        boxed("hull", sides=HULL, added=HULL_ADDED, drag=HULL_DRAG, density=DENSITY, volume=rest)
    )
    for name in blades:
        effects += boxed(
            name,
            sides=PADDLE,
            centre=(PADDLE_MIDDLE, 0.0, 0.0),
            added=_blade_added(),
            drag=PADDLE_DRAG,
            density=DENSITY,
        )
        if thrust:
            effects.append(Thrust(body=name, C=thrust, density=DENSITY))
    return tuple(effect for effect in effects if drag or not isinstance(effect, QuadraticDrag))


def _blade_added() -> tuple[float, ...]:
    length, width, _ = PADDLE
    strip = SHORTER * DENSITY * math.pi / 4.0 * width**2 * length
    # A strip about its middle: l^2 / 12 of its added mass; about its length a flat one has
    # pi/128 rho w^4 l (Newman 1977, Marine Hydrodynamics, table 4.3), which is w^2 / 32 of it.
    # Along itself a blade moves next to nothing, but no motion is quite free of water.
    along, across = 1e-3 * strip, strip * length**2 / 12.0
    return along, along, strip, strip * width**2 / 32.0, across, 1e-3 * across
