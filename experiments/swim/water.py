"""The swimmer's water, by the coefficients that are published for AQUA."""

from __future__ import annotations

import math

from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.thrust import Thrust
from morph.physics.fluid.wet import AXES

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

PADDLE_DRAG = 1.12
"""Drag coefficient of a paddle across its blade; the same source. Along it there is none."""

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
    length, width, thickness = PADDLE
    whole = robot.mass / DENSITY
    blade = length * width * thickness
    effects: list[Effect] = [
        AddedMass(body="hull", **dict(zip(AXES, HULL_ADDED, strict=True))),
        Buoyancy(body="hull", volume=whole - len(blades) * blade, density=DENSITY),
    ]
    if drag:
        effects.append(QuadraticDrag(body="hull", **_hull_drag()))
    for name in blades:
        effects += [
            _blade_added(name),
            Buoyancy(body=name, volume=blade, density=DENSITY, cx=PADDLE_MIDDLE),
        ]
        if drag:
            across, turning = _plate_drag(PADDLE_DRAG, width, length)
            effects.append(QuadraticDrag(body=name, z=across, ry=turning, cx=PADDLE_MIDDLE))
        if thrust:
            effects.append(Thrust(body=name, C=thrust, density=DENSITY))
    return tuple(effects)


def _blade_added(name: str) -> AddedMass:
    length, width, _ = PADDLE
    strip = SHORTER * DENSITY * math.pi / 4.0 * width**2 * length
    # A strip about its middle: l^2 / 12 of its added mass; about its length a flat one has
    # pi/128 rho w^4 l (Newman 1977, Marine Hydrodynamics, table 4.3), which is w^2 / 32 of it.
    # Along itself a blade moves next to nothing, but no motion is quite free of water.
    return AddedMass(
        body=name,
        x=1e-3 * strip,
        y=1e-3 * strip,
        z=strip,
        rx=strip * width**2 / 32.0,
        ry=strip * length**2 / 12.0,
        rz=1e-3 * strip * length**2 / 12.0,
        cx=PADDLE_MIDDLE,
    )


def _plate_drag(coefficient: float, width: float, length: float) -> tuple[float, float]:
    """Return the drag across a plate, N s2/m2, and about the middle of its length, N m s2/rad2.

    A strip at s feels rho C w (s omega)^2 ds / 2, at the arm s: rho C w l^4 / 64 in all.
    """
    return (
        0.5 * DENSITY * coefficient * width * length,
        DENSITY * coefficient * width * length**4 / 64.0,
    )


def _hull_drag() -> dict[str, float]:
    """Return the drag of a box: each face as a plate; about an axis, the four that it turns."""
    a, b, c = HULL
    x, y, z = HULL_DRAG
    return {
        "x": 0.5 * DENSITY * x * b * c,
        "y": 0.5 * DENSITY * y * a * c,
        "z": 0.5 * DENSITY * z * a * b,
        "rx": _plate_drag(y, a, c)[1] + _plate_drag(z, a, b)[1],
        "ry": _plate_drag(x, b, c)[1] + _plate_drag(z, b, a)[1],
        "rz": _plate_drag(x, c, b)[1] + _plate_drag(y, c, a)[1],
    }
