"""Soles: the points of a foot that are to touch the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.surface import surface

LEAST = 0.02
"""Share of the size of a foot, above its lowest point, that belongs to its sole."""
FLAT = 0.25
"""Least width of a sole, in its lengths, that is to stay level."""
SHANK, END = 0.3, 0.15
"""Least share of a leg's length that a last link without a foot has, and share of its length from
an end within which its joint is."""
CORNERS = 8
"""Most points of a sole on which forces act."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Sole:
    """What of a link is to touch the floor."""

    body: int
    """The link's number in the model."""
    points: Array
    """In the link's frame, m, and a radius about each, m, shape (points, 4)."""
    flat: bool
    """Whether it is wide enough to be put down level."""

    def placed(self, data: Any) -> Array:
        """Return the points in a pose, each as low as its radius reaches, m, shape (points, 3)."""
        turn = data.xmat[self.body].reshape(3, 3)
        points = np.asarray(self.points[:, :3] @ turn.T + data.xpos[self.body])
        points[:, 2] -= self.points[:, 3]
        return points

    def touch(self, data: Any) -> Array:
        """Return its middle in a pose and its lowest height, m, shape (3,)."""
        points = self.placed(data)
        return np.array([*points[:, :2].mean(axis=0), points[:, 2].min()])

    def corners(self, data: Any) -> Array:
        """Return those of its points in a pose that are farthest out, m, shape (points, 3)."""
        points = self.placed(data)
        angle = np.linspace(0.0, 2.0 * math.pi, CORNERS, endpoint=False)
        way = np.column_stack([np.cos(angle), np.sin(angle)])
        return np.asarray(points[sorted(set((points[:, :2] @ way.T).argmax(axis=0).tolist()))])


def sole_of(model: Any, data: Any, body: int, leg: Sequence[int] = ()) -> Sole:
    """Return the lowest points of a link and what is fixed to it, as it is placed in `data`.

    Of a leg without a foot, whose last link hangs from its joint by one end, they are the points
    that are farthest from the joint. Shapes that touch nothing count where no other is there.

    Args:
        model: The `mujoco.MjModel`.
        data: Its `MjData` after `mj_kinematics`.
        body: The link's number.
        leg: The joints between the trunk and the link, from the trunk outwards.
    """
    whole = np.flatnonzero(model.body_weldid[model.geom_bodyid] == model.body_weldid[body])
    solid = [at for at in whole if model.geom_contype[at] or model.geom_conaffinity[at]]
    points = [surface(model, data, int(at)) for at in (solid or whole)]
    every = np.concatenate(points) if points else np.array([[*data.xipos[body], 0.0]])
    height = every[:, 2] - every[:, 3]
    if leg and _is_shank(every[:, :3], data.xanchor[list(leg)]):
        height = -np.linalg.norm(every[:, :3] - data.xanchor[leg[-1]], axis=1) - every[:, 3]
    size = float(np.linalg.norm(np.ptp(every[:, :3], axis=0)))
    low = every[height <= height.min() + LEAST * size]
    turn = data.xmat[body].reshape(3, 3)
    own = np.column_stack([(low[:, :3] - data.xpos[body]) @ turn, low[:, 3]])
    spread = np.linalg.svd(own[:, :3] - own[:, :3].mean(axis=0), compute_uv=False)
    flat = len(spread) > 1 and spread[1] > FLAT * spread[0] and spread[1] > 0.0
    return Sole(body=body, points=own, flat=bool(flat))


def _is_shank(points: Array, joints: Array) -> bool:
    """Return whether the last link of a leg is long, and hangs from its joint by one end."""
    middle = points.mean(axis=0)
    along = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    reach = (points - middle) @ along
    share = (float((joints[-1] - middle) @ along) - reach.min()) / max(float(np.ptp(reach)), 1e-9)
    far = float(np.linalg.norm(points - joints[-1], axis=1).max())
    whole = float(np.linalg.norm(np.diff(joints, axis=0), axis=1).sum()) + far
    return bool(far > SHANK * whole and not END < share < 1.0 - END)
