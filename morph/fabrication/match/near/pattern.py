"""Patterns near a pattern: faster, wider, shifted, sooner, each role of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.roles import Role, actuator_roles
from morph.fabrication.match.near.ranges import narrowest_of
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
    roles: tuple[Role, ...]
    """The role of each actuator."""

    def make(self, values: Array) -> Pattern:
        """Return the pattern of these values."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        given = zip(self.pattern.swings, self.roles, strict=True)
        swings = tuple(_changed(swing, role, free) for swing, role in given)
        return replace(self.pattern, swings=swings)


def _changed(swing: Swing, role: Role, free: dict[str, float]) -> Swing:
    faster = 1.0 + free.get("frequency", 0.0)
    name, place = role.name, 0.0 if role.place is None else 2.0 * role.place - 1.0
    moved = free[f"{name} offset"] + place * free.get(f"{name} slant", 0.0)
    return Swing(
        offset=swing.offset + role.sense * moved,
        amplitude=swing.amplitude * (1.0 + free.get(f"{name} amplitude", 0.0)),
        frequency=swing.frequency * faster,
        phase=swing.phase + free.get(f"{name} phase", 0.0),
        rate=swing.rate * faster,
    )


def near_pattern(pattern: Pattern, robot: Robot, sigma: float) -> NearPattern:
    """Return the patterns near a pattern.

    Args:
        pattern: The pattern.
        robot: The body that it commands.
        sigma: How far a search reaches at first, in sides of the cube.
    """
    known = actuator_roles(robot)
    roles = tuple(known[each.actuator] for each in pattern.action)
    ranges = narrowest_of(roles, pattern.action)
    moving = {
        role.name for role, swing in zip(roles, pattern.swings, strict=True) if swing.amplitude
    }
    swinging = [name for name in ranges if name in moving]
    numbers = [_about("frequency", FASTER)] if swinging else []
    for name, narrowest in ranges.items():
        reach = min(narrowest, WIDEST / SHIFTED)
        numbers.append(_about(f"{name} offset", max(SHIFTED * reach, 1e-6)))
        if len({role.place for role in roles if role.name == name}) > 1:
            numbers.append(_about(f"{name} slant", max(SLANTED * reach, 1e-6)))
        if name in swinging:
            numbers.append(_about(f"{name} amplitude", WIDER))
            # Only phases between roles show.
            if name != swinging[0]:
                numbers.append(_about(f"{name} phase", SOONER))
    return NearPattern(pattern=pattern, roles=roles, numbers=tuple(numbers), sigma=sigma)


def _about(name: str, width: float) -> Number:
    return Number(name=name, low=-width, high=width, start=0.0)
