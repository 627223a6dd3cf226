"""What the fluid knows of a body: 58 numbers in MuJoCo's `body_user`, and where each stands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from morph.errors import EffectError

SIGNATURE = -0.71875
"""What stands first in a wet body: no description of a robot puts this number first of 55 or 58.

MuJoCo writes six digits, and as 0 what is 1e-12 of the greatest of a body's numbers; this one
is exact in six digits, and small.
"""

MARK = slice(0, 1)
"""`SIGNATURE` where the body is wet."""
SCALE = slice(1, 2)
"""How much of all that follows acts: 1, or 0 for a body that costs nothing."""
ADDED = slice(2, 23)
"""Added mass about the point below: the upper triangle of K, row by row; kg, kg m, kg m2."""
POINT = slice(23, 26)
"""The point to which added mass and linear drag refer, in the body's frame, m."""
DISPLACED = slice(26, 27)
"""Mass of the displaced fluid, kg."""
CENTRE = slice(27, 30)
"""Centre of buoyancy, in the body's frame, m."""
LINEAR = slice(30, 36)
"""Linear drag along and about the body's axes: N s/m, N m s/rad."""
QUADRATIC = slice(36, 42)
"""Quadratic drag along and about them: N s2/m2, N m s2/rad2."""
CURRENT = slice(42, 45)
"""Velocity of the fluid, in world axes, m/s."""
EDGE = slice(45, 48)
"""The middle of the edge that sheds momentum, in the body's frame, m."""
CHORD = slice(48, 51)
"""Unit vector from that edge into the body."""
NORMAL = slice(51, 54)
"""Unit vector normal to the paddle at that edge."""
SHED = slice(54, 55)
"""Virtual mass per length of what the edge sheds, times a coefficient, kg/m."""
APART = slice(55, 58)
"""From the point above to that to which quadratic drag refers, m."""
WIDTH, FEWER = 58, 55
"""How many there are, and without the last three, as in files of version 0.1; kernel.c has the
same table."""


def numbers_of(spec: Any, body: str) -> list[float]:
    """Return a body's numbers in a `mujoco.MjSpec`, fresh ones where it is not wet yet."""
    held = list(_body(spec, body).userdata)
    if len(held) >= FEWER and held[0] == SIGNATURE:
        return held + [0.0] * (WIDTH - len(held))
    return [SIGNATURE, 1.0] + [0.0] * (WIDTH - 2)


def write_numbers(spec: Any, body: str, numbers: Sequence[float]) -> None:
    """Make a body of a `mujoco.MjSpec` wet, with these numbers.

    A wet body's inertia is no longer diagonal, so MuJoCo is told not to treat it as simple.
    """
    part = _body(spec, body)
    part.userdata = list(numbers)
    part.simple = False
    spec.nuser_body = max(spec.nuser_body, WIDTH)


def add_numbers(spec: Any, body: str, where: slice, values: Sequence[float]) -> None:
    """Add values to some of a body's numbers, so that effects on one body add up."""
    numbers = numbers_of(spec, body)
    for at, value in zip(range(where.start, where.stop), values, strict=True):
        numbers[at] += value
    write_numbers(spec, body, numbers)


def _body(spec: Any, name: str) -> Any:
    body = spec.body(name)
    if body is None:
        raise EffectError(
            f"there is no body {name!r}", where="the fluid", fix="name a body of the robot"
        )
    return body
