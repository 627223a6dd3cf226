"""Errors of orientations along the axes of the parent, in which rates add up."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.sim.tangent import Coordinates

Axes = tuple[Array, ...]
"""Of each orientation the body's axes as columns, by the parent's, shape (samples, 3, 3)."""


def axes_of(space: Coordinates, position: Array) -> Axes:
    """Return the axes of all orientations along a motion.

    Source: Diebel 2006, Representing Attitude, eq. 125.

    Args:
        space: Where joints stand in a state.
        position: Shape (samples, nq).
    """
    results = []
    for at, _ in space.balls:
        w, x, y, z = position[:, at : at + 4].T
        rows = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
        results.append(np.moveaxis(np.array(rows), 2, 0))
    return tuple(results)


def along_parent(space: Coordinates, axes: Axes, values: Array) -> Array:
    """Return values by degree of freedom with rotations along the parent's axes.

    Args:
        space: Where joints stand in a state.
        axes: Of its orientations.
        values: Rotations along the body's axes, as in `qvel`, shape (samples, nv).
    """
    return _turned(space, list(axes), values)


def along_body(space: Coordinates, axes: Axes, values: Array) -> Array:
    """Return values by degree of freedom with rotations along the body's axes, as in `qvel`."""
    return _turned(space, [np.swapaxes(each, 1, 2) for each in axes], values)


def _turned(space: Coordinates, turns: list[Array], values: Array) -> Array:
    if not turns:
        return values
    result = values.copy()
    for turn, (_, dof) in zip(turns, space.balls, strict=True):
        part = slice(dof, dof + 3)
        result[:, part] = (turn @ values[:, part, None])[:, :, 0]
    return result


def jacobian_along_parent(
    space: Coordinates, axes: Axes, velocity: Array, jacobian: Array
) -> Array:
    """Return [dqacc/dq, dqacc/dv, M^-1] with rotations, but not forces, along the parent's axes.

    With R the body's axes, e a rotation of the parent's and n its rate, dv = R' n, to first order,
    and dn/dt = R d(dv)/dt + w x n, where w is the velocity along the parent's axes.

    Args:
        space: Where joints stand in a state.
        axes: Of its orientations.
        velocity: As in `qvel`, shape (samples, nv).
        jacobian: Shape (samples, nv, 3 nv).
    """
    if not axes:
        return jacobian
    result, dofs = jacobian.copy(), space.dofs
    spin = along_parent(space, axes, velocity)
    for turn, (_, dof) in zip(axes, space.balls, strict=True):
        rows = slice(dof, dof + 3)
        result[:, rows] = turn @ result[:, rows]
        for part in (rows, slice(dofs + dof, dofs + dof + 3)):
            result[:, :, part] = result[:, :, part] @ np.swapaxes(turn, 1, 2)
        cross = np.cross(spin[:, None, rows], np.eye(3)[None])  # Rows w x e_k: the columns of [w]x.
        result[:, rows, dofs + dof : dofs + dof + 3] += np.swapaxes(cross, 1, 2)
    return result
