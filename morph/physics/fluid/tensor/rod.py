"""The added mass of a cylinder or a capsule: of a limb, a rod, a wheel."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.errors import RobotError
from morph.physics.fluid.tensor.extrapolate import difference, extrapolated, limit_of_three
from morph.physics.fluid.tensor.influence import influence
from morph.physics.fluid.tensor.panels import Panels
from morph.physics.fluid.tensor.sides import check_sides
from morph.physics.fluid.tensor.tensor import Tensor

THINNEST = 1e-3
"""Least of radius and length by the greatest: thinner, and panels become too long."""

AROUND, ACROSS = 12, 3
"""Sectors of the circle, and rows of panels from the axis to the rim, at the coarsest level."""

ALONG = 3.0
"""Rows of panels along half of a side as long as the radius; more by the root of its length."""

MOST = 12
"""Most of those rows: far from the ends the flow hardly changes along a rod."""


def rod_tensor(radius: float, length: float, *, rounded: bool) -> Tensor:
    """Return the added-mass tensor of a cylinder along z about its centre.

    Direct boundary elements (`kirchhoff_of_panels`) on flat panels in equal sectors: what
    flows about one is known of all, as cos(m theta) with m = 0 along the axis and
    m = 1 across it, so that one row of panels carries the unknowns. Three levels, each of
    half the size, are extrapolated as in `box_tensor`. About its axis it moves no fluid.

    Args:
        radius: Of the cylinder, m.
        length: Of the cylinder, without its ends if those are rounded, m.
        rounded: Whether its ends are half balls, as a capsule's, or flat.

    Raises:
        RobotError: A length is not finite and positive, or is below a thousandth of the other.
    """
    check_sides("rod_tensor", radius=radius, length=length)
    size = max(radius, length)
    if min(radius, length) < THINNEST * size and not (rounded and length < radius):
        raise RobotError(
            f"radius {radius:g} m and length {length:g} m: one is below {THINNEST:g} of the other",
            where="morph.physics.fluid.tensor.rod_tensor",
            fix="give the disc or wire the thickness that it has",
        )
    r, half = radius / size, length / size / 2.0
    coarse, middle, fine = (_diagonal(_profile(r, half, n, rounded), n * AROUND) for n in (1, 2, 4))
    limit, other = limit_of_three(coarse, middle, fine), extrapolated(middle, fine)
    volume = np.pi * r**2 * (2.0 * half + (4.0 / 3.0 * r if rounded else 0.0))
    # Of a cylinder of this volume and length: a scale, for which its ends do not matter.
    across = r**2 / 4.0 + (half + (r / 2.0 if rounded else 0.0)) ** 2 / 3.0
    solid = volume * np.array([1.0, 1.0, 1.0, across, across, r**2 / 2.0])
    return Tensor(
        matrix=np.diag(limit),
        volume=float(volume),
        error=difference(np.diag(limit), np.diag(other), solid),
        panels=4 * AROUND * (len(_profile(r, half, 4, rounded)) - 1),
    ).scaled(size)


def _profile(r: float, half: float, level: int, rounded: bool) -> Array:
    """Return radius and height of rings from the lower pole to the upper, shape (k, 2)."""
    rows = level * int(np.clip(np.rint(ALONG * np.sqrt(half / r)), 1, MOST))
    if rounded:
        angle = np.linspace(-np.pi / 2.0, 0.0, 2 * ACROSS * level + 1)
        end = np.stack([r * np.cos(angle), r * np.sin(angle) - half], axis=1)
        end[0, 0] = 0.0
    else:
        part = _towards_edge(ACROSS * level)
        end = np.stack([r * part, np.full(len(part), -half)], axis=1)
    side = np.stack([np.full(rows + 1, r), -half * _towards_edge(rows)[::-1]], axis=1)
    lower = np.concatenate([end, side[1:]])
    upper = lower[:-1][::-1] * (1.0, -1.0)
    return np.concatenate([lower, upper])


def _towards_edge(rows: int) -> Array:
    """Return places from 0 to 1 whose distance from 1 grows as a square; see `octant`."""
    places: Array = 1.0 - np.linspace(1.0, 0.0, rows + 1) ** 2
    return places


def _diagonal(profile: Array, sectors: int) -> Array:
    """Return the six entries of the tensor; the others vanish by symmetry."""
    own = _sector(profile, sectors)
    angles = 2.0 * np.pi * np.arange(sectors) / sectors
    turns = np.zeros((sectors, 3, 3))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(angles)
    turns[:, 1, 0], turns[:, 0, 1], turns[:, 2, 2] = np.sin(angles), -np.sin(angles), 1.0
    every = Panels(corners=np.einsum("sij,pcj->spci", turns, own).reshape(-1, 3, 3))
    areas = every.areas.reshape(sectors, -1, 2)
    rows = areas.shape[1]
    weights = areas / areas.sum(axis=2, keepdims=True)
    centres = (every.centroids.reshape(sectors, rows, 2, 3) * weights[..., None]).sum(axis=2)
    normals = every.normals.reshape(sectors, rows, 2, 3)[:, :, 0]
    flux = np.concatenate([normals, np.cross(centres, normals)], axis=2)
    double, single = influence(centres[0], every, np.repeat(flux.reshape(-1, 6), 2, axis=0))
    pairs = double.reshape(rows, sectors, rows, 2).sum(axis=3)
    entries, whole = np.zeros(6), areas[0].sum(axis=1)
    # About y and about x, as along x and y, the flow is the same a quarter turn on.
    for wave, motions, share in ((0, (2,), 1.0), (1, (0, 4), 0.5)):
        matrix = np.einsum("isj,s->ij", pairs, np.cos(wave * angles)) + 0.5 * np.eye(rows)
        potential = np.linalg.solve(matrix, -single[:, motions])
        pushed = whole[:, None] * flux[0][:, motions]
        entries[list(motions)] = -share * sectors * (potential * pushed).sum(axis=0)
    entries[[1, 3]] = entries[[0, 4]]
    return entries


def _sector(profile: Array, sectors: int) -> Array:
    """Return the triangles of one sector about the x axis, two a row, shape (2 rows, 3, 3)."""
    turn = 2.0 * np.pi / sectors
    # Area of a regular polygon of n corners at radius R: n/2 R^2 sin(2 pi / n).
    radius = profile[:, 0] * np.sqrt(turn / np.sin(turn))
    sides = [
        np.stack([radius * np.cos(t), radius * np.sin(t), profile[:, 1]], axis=1)
        for t in (-turn / 2.0, turn / 2.0)
    ]
    right, left = sides
    results = []
    for a, b, c, d in zip(right[:-1], left[:-1], left[1:], right[1:], strict=True):
        # At a pole two corners are one: the triangle is halved the other way.
        if np.array_equal(a, b):
            results += [(a, (c + d) / 2.0, d), (a, c, (c + d) / 2.0)]
        elif np.array_equal(c, d):
            results += [(a, (a + b) / 2.0, c), ((a + b) / 2.0, b, c)]
        else:
            results += [(a, b, c), (a, c, d)]
    return np.array(results)
