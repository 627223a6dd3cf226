"""Dry friction as impulses that stop what they can: set-valued, so a joint truly sticks."""

from __future__ import annotations

import numpy as np

from experiments.conceal.equations import Array


def after_friction(
    v: Array, inverse: tuple[Array, ...], limit: Array, *, sweeps: int = 40
) -> Array:
    """Return the velocities after the friction of one step.

    Projected Gauss-Seidel on the impulses: each joint's impulse is the one that
    brings it to rest, clipped to +-limit; a joint that its impulse could stop is at
    exactly 0. With friction at one joint only, one sweep is exact. Source: Moreau
    1988 (time stepping at velocity level), Jean 1999 (the projection).

    Args:
        v: Velocities that the step would reach without friction, (joints, rows).
        inverse: Packed inverse of the mass matrix.
        limit: Level of friction times the step, N m s or N s, (joints, rows).
        sweeps: Most sweeps where two joints of one row rub.
    """
    if len(v) == 1:
        return np.where(np.abs(v) <= inverse[0] * limit, 0.0, v - np.sign(v) * inverse[0] * limit)
    a, b, c = inverse
    diagonal, impulse, out = (a, c), np.zeros_like(v), v.copy()
    both = bool(((limit[0] > 0) & (limit[1] > 0)).any())
    stuck = np.zeros(v.shape, dtype=bool)
    for _ in range(sweeps if both else 1):
        largest = 0.0
        for joint in range(2):
            wanted = impulse[joint] - out[joint] / diagonal[joint]
            new = np.clip(wanted, -limit[joint], limit[joint])
            change = new - impulse[joint]
            impulse[joint] = new
            stuck[joint] = (np.abs(wanted) <= limit[joint]) & (limit[joint] > 0)
            out[joint] += diagonal[joint] * change
            out[1 - joint] += b * change
            if both:
                largest = max(largest, float(np.abs(diagonal[joint] * change).max()))
        if both and largest < 1e-14:
            break
    out[stuck] = 0.0
    return out
