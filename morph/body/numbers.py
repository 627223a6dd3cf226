"""Numbers in the attributes of a description, or a refusal that names the line."""

from __future__ import annotations

import math
import sys

import numpy as np

from morph.arrays import Array
from morph.body.xml import Element
from morph.errors import RobotError

LARGEST = 1e12
"""Greatest length, mass or angle that is still taken for one, in its unit."""

SMALLEST = 1e-15
"""Least size or limit that is more than nothing: MuJoCo's mjMINVAL."""

LONGEST = 1000
"""Most characters of an attribute that holds numbers."""


def numbers(element: Element, key: str, count: int, default: tuple[float, ...]) -> Array:
    """Return an attribute's numbers, shape (count,); the default if it is absent or blank.

    Raises:
        RobotError: They are not that many finite numbers.
    """
    text = element.get(key, "").strip()
    if not text:
        return np.array(default, dtype=float)
    values = _floats(text)
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
    values = _floats(text)
    if len(values) != 1:
        raise RobotError(
            f"<{element.tag}> has {key}={text[:80]!r}, not a number",
            where=element.place,
            fix=f"write {key} as one number",
        )
    return 0.0 if abs(values[0]) <= SMALLEST else values[0]


def _floats(text: str) -> list[float]:
    """Return the numbers in a text; none if it holds anything else."""
    # Python reads 1_0 as ten; no other reader of descriptions does.
    if len(text) > LONGEST or "_" in text or not text.isascii():
        return []
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return []
    # What is too small for a double's full precision is lost on the way to MuJoCo.
    return [0.0 if abs(value) < sys.float_info.min else value for value in values]


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


def float_or(word: str, default: float) -> float:
    """Return a word's number; the default if it is none."""
    try:
        return float(word)
    except ValueError:
        return default
