"""The trailing edge of a paddle or fin, read off the shapes of its link."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.errors import EffectError


@dataclass(frozen=True, kw_only=True)
class Edge:
    """Where a link sheds the momentum of the water that it pushes aside."""

    middle: Array
    """Its middle, in the link's frame, m, shape (3,)."""
    chord: Array
    """Unit vector from it into the link, shape (3,)."""
    normal: Array
    """Unit vector across the link where it is thinnest, shape (3,)."""
    span: float
    """Its length, m."""


def edge_at(middle: Array, normal: Array, span: float) -> Edge:
    """Return the edge whose chord points from its middle to the link's origin, across the normal.

    Raises:
        EffectError: The normal is zero, or the middle is at the origin or along the normal.
    """
    size = float(np.linalg.norm(normal))
    unit = normal / size if size > 0.0 else normal
    chord = (middle @ unit) * unit - middle
    length = float(np.linalg.norm(chord))
    if size == 0.0 or not length > 1e-9:
        raise EffectError(
            f"an edge at {middle.tolist()} m with the normal {normal.tolist()} has no chord",
            where="thrust",
            fix="give the edge's middle, away from the link's origin, and its normal",
        )
    return Edge(middle=middle, chord=chord / length, normal=unit, span=span)


def trailing_edge(model: Any, body: str) -> Edge:
    """Return the trailing edge of a body of a `mujoco.MjModel`.

    Of the box around what the water touches, in the link's axes, it is the side that is farthest
    from the link's origin, its hinge; of two as far, the one behind. Its normal is the axis along
    which that box is thinnest. The water touches what collides, or all where nothing does.

    Raises:
        EffectError: The link has no shape, or one too thick for a paddle.
    """
    low, high = _box(model, body)
    sides = high - low
    thin, *wide = np.argsort(sides, kind="stable")
    if not sides[thin] < 0.25 * sides[wide[0]]:
        raise EffectError(
            f"its shapes are {sides[0]:.3g} by {sides[1]:.3g} by {sides[2]:.3g} m: no paddle, "
            "which is less than a quarter as thick as it is wide",
            where=f"link {body}",
            fix="give thrust to a paddle, a fin or a blade",
        )
    # Sorted by axis and side, x from behind first, so that the first of two as far is behind.
    reach = [(axis, side, abs((low, high)[side][axis])) for axis in sorted(wide) for side in (0, 1)]
    farthest = max(distance for _, _, distance in reach)
    axis, side, _ = next(each for each in reach if each[2] >= farthest * (1.0 - 1e-9))
    across = next(other for other in wide if other != axis)
    middle = 0.5 * (low + high)
    middle[axis] = (low, high)[side][axis]
    return Edge(
        middle=middle,
        chord=np.eye(3)[axis] * (1.0 if side == 0 else -1.0),
        normal=np.eye(3)[thin],
        span=float(sides[across]),
    )


def _box(model: Any, name: str) -> tuple[Array, Array]:
    """Return the corners of the box around a body's wet shapes, in its frame, (3,) each."""
    body = model.body(name).id
    shapes = np.flatnonzero(model.geom_bodyid == body)
    touching = [g for g in shapes if model.geom_contype[g] or model.geom_conaffinity[g]]
    corners = np.array(np.meshgrid(*[(-1.0, 1.0)] * 3)).reshape(3, 8).T
    spots = [np.empty((0, 3))]
    for geom in touching or shapes:
        turned = np.empty(9)
        mujoco.mju_quat2Mat(turned, model.geom_quat[geom])
        inside = model.geom_aabb[geom, :3] + corners * model.geom_aabb[geom, 3:]
        spots.append(model.geom_pos[geom] + inside @ turned.reshape(3, 3).T)
    result = np.concatenate(spots)
    if not len(result):
        raise EffectError(
            "it has no shape that water could touch",
            where=f"link {name}",
            fix="give the link a shape in its description",
        )
    return result.min(axis=0), result.max(axis=0)
