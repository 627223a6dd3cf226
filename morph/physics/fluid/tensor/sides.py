"""The check that the lengths of simple solids share."""

from __future__ import annotations

import math

from morph.errors import RobotError


def check_sides(where: str, **lengths: float) -> None:
    """Check that lengths are finite and positive.

    Raises:
        RobotError: One is not.
    """
    for name, length in lengths.items():
        if not (math.isfinite(length) and length > 0.0):
            raise RobotError(
                f"{name} = {length:g} m",
                where=f"morph.physics.fluid.tensor.{where}",
                fix="give a finite length above 0",
            )
