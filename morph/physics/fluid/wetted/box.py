"""The box that stands for a solid: of its volume, its centre and its spread."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.tessellate import box_mesh

ROUND = 1e-6
"""Part by which numbers may differ and still count as the same."""


@dataclass(frozen=True, kw_only=True)
class Box:
    """A box in a link's frame."""

    sides: Array
    """Along its own axes, m, shape (3,)."""
    centre: Array
    """m, shape (3,)."""
    axes: Array
    """Its own axes as columns, in the link's frame, shape (3, 3); a rotation."""

    @property
    def mesh(self) -> Mesh:
        """Its surface as 12 triangles, in the link's frame."""
        mesh = box_mesh(self.sides)
        return Mesh(vertices=mesh.vertices @ self.axes.T + self.centre, faces=mesh.faces)


def equivalent_box(mesh: Mesh) -> Box:
    """Return the box with the volume, the centre and the ratios of spread of a solid.

    A box of sides a, b, c has second moments V a^2 / 12 and so on along its axes;
    the sides go with the roots of the solid's, and then to its volume. The box of
    a box is that box.
    """
    second = np.trace(mesh.inertia) / 2.0 * np.eye(3) - mesh.inertia
    axes = np.eye(3)
    if np.abs(second - np.diag(np.diag(second))).max() > ROUND * np.trace(second):
        axes = _nearest_order(np.linalg.eigh(second)[1])
    sides = np.sqrt(np.diag(axes.T @ second @ axes))
    sides *= (mesh.volume / sides.prod()) ** (1.0 / 3.0)
    return Box(sides=sides, centre=mesh.com, axes=axes)


def as_box(mesh: Mesh) -> Box | None:
    """Return the box that a solid is; None if it is none."""
    box = equivalent_box(mesh)
    inside = (mesh.vertices - box.centre) @ box.axes
    off = np.abs(2.0 * np.abs(inside).max(axis=0) - box.sides).max()
    return box if off < ROUND * box.sides.max() else None


def _nearest_order(axes: Array) -> Array:
    """Return axes in the order and with the signs that turn the frame least."""
    from scipy.optimize import linear_sum_assignment

    _, order = linear_sum_assignment(-np.abs(axes))
    ordered = axes[:, order] * np.where(np.diag(axes[:, order]) < 0, -1.0, 1.0)
    if np.linalg.det(ordered) < 0:
        # Two axes that lie across may keep the wrong sign between them.
        ordered[:, int(np.argmin(np.abs(np.diag(ordered))))] *= -1.0
    return np.asarray(ordered)
