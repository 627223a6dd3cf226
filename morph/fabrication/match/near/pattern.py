"""Patterns near a pattern: faster, wider, shifted, sooner, each role of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.fabrication.match.near.roles import places_of, ranges_of, roles_of
from morph.policy.pattern import Pattern, Swing
from morph.search.family.family import Family, Number

FASTER, WIDER, SOONER = 0.4, 0.6, 0.8
"""Farthest change of frequency and amplitude, as shares of themselves, and of a phase, rad."""

SHIFTED, SLANTED = 0.15, 0.1
"""Farthest change of an offset, and of its difference between front and rear, in ranges."""

WIDEST = 0.4
"""Farthest that an offset is changed, in the unit of its command."""


@dataclass(frozen=True, kw_only=True)
class NearPattern(Family):
    """Patterns whose roles swing a little otherwise; legs that are alike stay alike."""

    pattern: Pattern
    """The pattern that they are near."""

    def make(self, values: Array) -> Pattern:
        """Return the pattern of these values."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        action = self.pattern.action
        given = zip(self.pattern.swings, roles_of(action), places_of(action), strict=True)
        swings = tuple(_changed(swing, role, float(place), free) for swing, role, place in given)
        return replace(self.pattern, swings=swings)


def _changed(swing: Swing, role: str, place: float, free: dict[str, float]) -> Swing:
    faster = 1.0 + free.get("frequency", 0.0)
    return Swing(
        offset=swing.offset + free[f"{role} offset"] + place * free.get(f"{role} slant", 0.0),
        amplitude=swing.amplitude * (1.0 + free.get(f"{role} amplitude", 0.0)),
        frequency=swing.frequency * faster,
        phase=swing.phase + free.get(f"{role} phase", 0.0),
        rate=swing.rate * faster,
    )


def near_pattern(pattern: Pattern, sigma: float) -> NearPattern:
    """Return the patterns near a pattern.

    Args:
        pattern: The pattern.
        sigma: How far a search reaches at first, in sides of the cube.
    """
    roles, ranges = roles_of(pattern.action), ranges_of(pattern.action)
    places = places_of(pattern.action)
    swinging = dict.fromkeys(
        role for role, swing in zip(roles, pattern.swings, strict=True) if swing.amplitude != 0.0
    )
    numbers = [_about("frequency", FASTER)] if swinging else []
    for role in dict.fromkeys(roles):
        those = np.array([each == role for each in roles])
        reach = min(float(ranges[those].min()), WIDEST / SHIFTED)
        numbers.append(_about(f"{role} offset", max(SHIFTED * reach, 1e-6)))
        if np.ptp(places[those]) > 0.0:
            numbers.append(_about(f"{role} slant", max(SLANTED * reach, 1e-6)))
        if role in swinging:
            numbers.append(_about(f"{role} amplitude", WIDER))
            # Only phases between roles show.
            if role != next(iter(swinging)):
                numbers.append(_about(f"{role} phase", SOONER))
    return NearPattern(pattern=pattern, numbers=tuple(numbers), sigma=sigma)


def _about(name: str, width: float) -> Number:
    return Number(name=name, low=-width, high=width, start=0.0)
