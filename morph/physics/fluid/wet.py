"""What the effects of a fluid on one link have in common."""

from __future__ import annotations

from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import EffectError
from morph.physics.body.point import PointEffect
from morph.physics.body_jacobian import cross_matrix
from morph.physics.fluid.numbers import (
    ADDED,
    APART,
    LINEAR,
    POINT,
    QUADRATIC,
    numbers_of,
    write_numbers,
)
from morph.physics.fluid.reference import tensor

AXES = ("x", "y", "z", "rx", "ry", "rz")
"""Along and about a link's axes; the order of every six numbers of the fluid."""


class WetEffect(PointEffect):
    """An effect of a fluid on one link."""

    @classmethod
    def suspects(cls, robot: Robot) -> tuple[str, ...]:
        """Return the links of a body whose card puts it into water."""
        return cls.places(robot) if robot.card is not None and robot.card.water else ()


def shift(centre: Array) -> Array:
    """Return the matrix (6, 6) that takes a link's velocity at its origin to that at a point.

    With v the linear and w the angular velocity: v + w x c, w.
    """
    whole = np.eye(6)
    whole[:3, 3:] = -cross_matrix(centre)
    return whole


def refer(spec: Any, body: str, centre: Array, label: str, *, quadratic: bool) -> None:
    """Write the point to which a link's linear or quadratic drag refers.

    Its added mass is told about the point of the linear one, and the other point stays.

    Raises:
        EffectError: Another drag of this kind on this link refers to another point.
    """
    numbers = numbers_of(spec, body)
    held = np.array(numbers[POINT])
    before = held + np.array(numbers[APART]) if quadratic else held
    if any(numbers[QUADRATIC if quadratic else LINEAR]) and not np.allclose(before, centre):
        raise EffectError(
            f"it refers to the point {centre.tolist()}, such a drag of {body} to {before.tolist()}",
            where=f"effect {label}",
            fix="give both the same cx, cy and cz",
        )
    if quadratic:
        numbers[APART] = (centre - held).tolist()
        write_numbers(spec, body, numbers)
        return
    if not np.array_equal(held, centre):
        back = shift(held - centre)
        whole = back.T @ tensor(np.array(numbers[ADDED])) @ back
        numbers[ADDED] = whole[np.triu_indices(6)].tolist()
    numbers[POINT] = centre.tolist()
    numbers[APART] = (np.array(numbers[APART]) + held - centre).tolist()
    write_numbers(spec, body, numbers)
