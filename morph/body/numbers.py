"""Numbers in the attributes of a description, or a refusal that names the line."""

from __future__ import annotations

import math

import numpy as np

from morph.arrays import Array
from morph.body.xml import Element
from morph.errors import RobotError

LARGEST = 1e12
"""Greatest length, mass or angle that is still taken for one, in its unit."""


def numbers(element: Element, key: str, count: int, default: tuple[float, ...]) -> Array:
    """Return an attribute's numbers, shape (count,); the default if it is absent or blank.

    Raises:
        RobotError: They are not that many finite numbers.
    """
    text = element.get(key, "").strip()
    if not text:
        return np.array(default, dtype=float)
    try:
        values = [float(word) for word in text.split() if "_" not in word]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) <= LARGEST for value in values):
        many = "a finite number" if count == 1 else f"{count} finite numbers"
        raise RobotError(
            f"<{element.tag}> has {key}={text[:80]!r}, not {many}",
            where=element.place,
            fix=f"write {key} as {many}",
        )
    return np.array(values)


def number(element: Element, key: str, default: float) -> float:
    """Return an attribute's number; the default if it is absent or blank.

    Raises:
        RobotError: It is not one finite number.
    """
    return float(numbers(element, key, 1, (default,))[0])


def maybe_number(element: Element, key: str) -> float | None:
    """Return an attribute's number, which may be infinite or NaN; None if it is absent or blank.

    Limits are read so: what is absurd in them is a finding, not the end.

    Raises:
        RobotError: It is not one number.
    """
    text = element.get(key, "").strip()
    if not text:
        return None
    try:
        if "_" in text:
            raise ValueError(text)
        return float(text)
    except ValueError as error:
        raise RobotError(
            f"<{element.tag}> has {key}={text[:80]!r}, not a number",
            where=element.place,
            fix=f"write {key} as one number",
        ) from error


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Return the rotation matrix of URDF's angles, shape (3, 3).

    About the fixed x, then y, then z axis: R = Rz(yaw) Ry(pitch) Rx(roll); source:
    URDF specification, element `origin`.
    """
    cr, sr = math.cos(roll), math.sin(roll)
    cp, sp = math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
