"""The added mass of a box: of a paddle, a hull, a cube."""

from __future__ import annotations

import itertools

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import RobotError
from morph.physics.fluid.tensor.extrapolate import difference, extrapolated, limit_of_three
from morph.physics.fluid.tensor.influence import influence
from morph.physics.fluid.tensor.octant import PARITY, Octant, octant
from morph.physics.fluid.tensor.sides import check_sides
from morph.physics.fluid.tensor.tensor import Tensor

THINNEST = 1e-3
"""Least side by the greatest: thinner, and rectangles beside an edge become too long."""

FINEST = 432
"""Rectangles on an eighth of the box, about, at the finest of three levels."""


def box_tensor(a: float, b: float, c: float) -> Tensor:
    """Return the added-mass tensor of a box about its centre.

    Direct boundary elements (`kirchhoff_of_panels`) on rectangles that grow smaller
    towards the edges, where the flow is infinitely fast. The box is its own mirror
    image three times over, so an eighth of it carries the unknowns. Three levels,
    each of half the size, are extrapolated at the order that they show; what second order
    would give instead differs by the error. Takes about a second.

    Args:
        a: Side along x, m.
        b: Side along y, m.
        c: Side along z, m.

    Raises:
        RobotError: A side is not finite and positive, or is below a thousandth of another.
    """
    check_sides("box_tensor", a=a, b=b, c=c)
    sides = np.array((a, b, c))
    # Worked out at unit size, so that no metre is hidden in a tolerance.
    size = float(sides.max())
    if sides.min() < THINNEST * size:
        raise RobotError(
            f"sides {a:g} x {b:g} x {c:g} m: the least is below {THINNEST:g} of the greatest",
            where="morph.physics.fluid.tensor.box_tensor",
            fix="give the plate or rod the thickness that it has",
        )
    unit = sides / size
    counts = _counts(unit)
    coarse, middle, fine = (_diagonal(octant(unit, counts * level)) for level in (1, 2, 4))
    limit, other = limit_of_three(coarse, middle, fine), extrapolated(middle, fine)
    volume = float(unit.prod())
    solid = volume * np.concatenate([np.ones(3), ((unit**2).sum() - unit**2) / 12.0])
    return Tensor(
        matrix=np.diag(limit),
        volume=volume,
        error=difference(np.diag(limit), np.diag(other), solid),
        panels=8 * int(counts @ np.roll(counts, 1)) * 16,
    ).scaled(size)


def _counts(sides: Array) -> Integers:
    """Return rectangles per half side at the coarsest level, shape (3,), at least 1.

    With gaps that grow as the square of the distance in steps, equal first gaps
    need counts as the roots of the sides.
    """
    root = np.sqrt(sides)
    scale = np.sqrt(FINEST / 16.0 / (root @ np.roll(root, 1)))
    counts: Integers = np.maximum(1, np.rint(scale * root)).astype(np.int64)
    return counts


def _diagonal(part: Octant) -> Array:
    """Return the six entries of the tensor; the others vanish by symmetry."""
    count = len(part.centres)
    matrices, pushed = np.zeros((6, count, count)), np.zeros((count, 6))
    for signs in itertools.product((1.0, -1.0), repeat=3):
        # What an image causes here is what the original causes at the image of here.
        double, single = influence(part.centres * signs, part.triangles, part.doubled_flux)
        double = double[:, 0::2] + double[:, 1::2]
        parity = np.prod(np.where(np.array(signs) < 0.0, PARITY, 1.0), axis=1)
        matrices += parity[:, None, None] * double
        pushed += parity * single
    matrices[:, np.arange(count), np.arange(count)] += 0.5
    potential = np.linalg.solve(matrices, -pushed.T[:, :, None])[:, :, 0]
    entries: Array = -8.0 * np.einsum("jk,k,kj->j", potential, part.areas, part.flux)
    return entries
