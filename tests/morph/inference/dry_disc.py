"""A disc with dry friction, integrated by hand: no code of morph or MuJoCo takes part."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np

STEP, FINE, INERTIA = 0.004, 16, 0.02
"""Seconds between readings, steps of the integration in each, and the disc's inertia, kg m2."""


def turned(
    commands: Iterable[float],
    torque: Callable[[float, float, float], float],
    *,
    coulomb: float,
    angle: float = 0.0,
) -> list[float]:
    """Return the disc's angle when each command arrives, rad, from rest on.

    Args:
        commands: One in each step.
        torque: Of a command, the angle and the rate, N m.
        coulomb: Friction, N m.
        angle: At the start, rad.
    """
    rate, read, step = 0.0, [], STEP / FINE
    for now in commands:
        read.append(angle)
        for _ in range(FINE):
            moved = rate + step * torque(now, angle, rate) / INERTIA
            # Friction stops the disc within a step, or takes all that it can.
            rate = np.sign(moved) * max(abs(moved) - step * coulomb / INERTIA, 0.0)
            angle += step * rate
    return read
