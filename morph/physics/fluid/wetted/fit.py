"""Whether mass, density and volume go together, before any of them gives a wrong number."""

from __future__ import annotations

import math

from morph.errors import EffectError, RobotError

AIR = 1.2
"""Density of air, kg/m3, at 20 degrees and sea level: a body lighter than that rises in it."""

TRIM = 0.05
"""Difference of mass and displaced mass, as a part of the mass, that trim explains."""


def fit_of(mass: float, volume: float, density: float, *, where: str = "the body") -> str:
    """Return what does not fit between a body's mass and its volume in a fluid; empty if all does.

    A swimmer is trimmed to the mass that it displaces; where the two differ by more than
    `TRIM` of the mass, its shape, its scale or its mass is most likely not what it seems.

    Args:
        mass: With everything on board, kg.
        volume: Displaced, m3.
        density: Of the fluid, kg/m3.
        where: What to call the body in an error.

    Raises:
        RobotError: The mass or the volume is not a positive number, or the body is
            lighter than the air that it displaces.
        EffectError: The density is not a positive number.
    """
    check_density(density, where=where)
    for name, value, unit in (("mass", mass, "kg"), ("displaced volume", volume, "m3")):
        if not (math.isfinite(value) and value > 0):
            raise RobotError(
                f"its {name} is {value:g} {unit}",
                where=where,
                fix=f"give a {name} above 0",
            )
    if mass < AIR * volume:
        raise RobotError(
            f"it weighs {mass:g} kg and displaces {1e3 * volume:.4g} litres, which of air alone "
            f"weigh {AIR * volume:.4g} kg",
            where=where,
            fix="check the unit of its shapes: a scale of 0.001 turns millimetres into metres",
        )
    lift = density * volume
    if abs(lift - mass) <= TRIM * mass:
        return ""
    verb = "floats" if lift > mass else "sinks"
    return (
        f"it weighs {mass:.4g} kg and displaces {lift:.4g} kg of the fluid "
        f"({1e3 * volume:.4g} litres of {density:.4g} kg/m3): it {verb}, "
        f"unless its volume is {1e3 * mass / density:.4g} litres"
    )


def check_density(density: float, *, where: str = "the fluid") -> None:
    """Check the density of a fluid, kg/m3.

    Raises:
        EffectError: It is not a positive number.
    """
    if not (math.isfinite(density) and density > 0):
        raise EffectError(
            f"the density of the fluid is {density:g} kg/m3",
            where=where,
            fix="give a density above 0: 1000 for fresh water, 1025 for the sea, 1.2 for air",
        )
