"""The added mass of an ellipsoid, in closed form."""

from __future__ import annotations

import math

import numpy as np

from morph.physics.fluid.tensor.sides import check_sides
from morph.physics.fluid.tensor.tensor import Tensor

ROUND = 1e-7
"""Difference of two semi-axes, as a part of them, below which turning moves no fluid."""


def ellipsoid_tensor(a: float, b: float, c: float) -> Tensor:
    """Return the added-mass tensor of an ellipsoid about its centre.

    With alpha = a b c * integral from 0 of ds / ((a^2 + s) D), D^2 = (a^2 + s)(b^2 + s)
    (c^2 + s), and likewise beta and gamma (Lamb 1932, art. 114, eq. 5 to 7), and V
    the volume: along a, V alpha / (2 - alpha) (art. 114, eq. 9); about a,
    V / 5 * (b^2 - c^2)^2 (gamma - beta) / (2 (b^2 - c^2) + (b^2 + c^2)(beta - gamma))
    (art. 115, eq. 3). The integral is Carlson's R_D.

    Args:
        a: Semi-axis along x, m.
        b: Semi-axis along y, m.
        c: Semi-axis along z, m.

    Raises:
        RobotError: A semi-axis is not finite and positive.
    """
    # Loads a library that few need.
    from scipy.special import elliprd

    check_sides("ellipsoid_tensor", a=a, b=b, c=c)
    x, y, z = a * a, b * b, c * c
    third = 2.0 / 3.0 * a * b * c
    alpha = third * float(elliprd(y, z, x))
    beta = third * float(elliprd(z, x, y))
    gamma = third * float(elliprd(x, y, z))
    volume = 4.0 / 3.0 * math.pi * a * b * c
    along = [volume * axis / (2.0 - axis) for axis in (alpha, beta, gamma)]
    about = [
        volume / 5.0 * _turning(y, z, beta, gamma),
        volume / 5.0 * _turning(z, x, gamma, alpha),
        volume / 5.0 * _turning(x, y, alpha, beta),
    ]
    return Tensor(matrix=np.diag(along + about), volume=volume)


def _turning(y: float, z: float, beta: float, gamma: float) -> float:
    # As y approaches z the formula is 0 / 0, and its value 0 to second order.
    if abs(y - z) < ROUND * (y + z):
        return 0.0
    return (y - z) ** 2 * (gamma - beta) / (2.0 * (y - z) + (y + z) * (beta - gamma))
