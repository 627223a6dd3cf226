"""How far shapes reach: the points of their surfaces that may be lowest."""

from __future__ import annotations

import math
from itertools import product
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array

PLANE = mujoco.mjtGeom.mjGEOM_PLANE.value
FREE, SLIDE = mujoco.mjtJoint.mjJNT_FREE.value, mujoco.mjtJoint.mjJNT_SLIDE.value
UPRIGHT = 0.9
"""Least share of a slide's axis that is upright for it to lift what it carries."""


def lowest_of(model: Any, data: Any, root: int) -> float | None:
    """Return the height of the lowest point of what hangs from a link, m; None without shapes.

    Shapes that touch nothing count only where no other is there.
    """
    under = {root}
    for body in range(root + 1, model.nbody):
        if int(model.body_parentid[body]) in under:
            under.add(body)
    mine = [at for at in range(model.ngeom) if int(model.geom_bodyid[at]) in under]
    solid = [at for at in mine if model.geom_contype[at] or model.geom_conaffinity[at]]
    points = [surface(model, data, at) for at in (solid or mine)]
    return min((float((each[:, 2] - each[:, 3]).min()) for each in points), default=None)


def height_of(model: Any, data: Any, body: int) -> tuple[int, float] | None:
    """Return where in `qpos` a link's height is, and how much it lifts the link; None: nowhere."""
    first = int(model.body_jntadr[body])
    for at in range(first, first + int(model.body_jntnum[body])):
        if model.jnt_type[at] == FREE:
            return int(model.jnt_qposadr[at]) + 2, 1.0
        upwards = float(data.xaxis[at, 2])
        if model.jnt_type[at] == SLIDE and abs(upwards) > UPRIGHT:
            return int(model.jnt_qposadr[at]), upwards
    return None


def surface(model: Any, data: Any, geom: int) -> Array:
    """Return points of a shape in the world and a radius about each, m, shape (points, 4).

    The radius holds the margins from which MuJoCo pushes a shape off a floor: its own, and that
    of the description's floor.
    """
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    turn, place = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
    kinds = mujoco.mjtGeom
    radius = 0.0
    if kind == kinds.mjGEOM_SPHERE:
        own, radius = np.zeros((1, 3)), float(size[0])
    elif kind == kinds.mjGEOM_CAPSULE:
        own, radius = np.array([[0.0, 0.0, size[1]], [0.0, 0.0, -size[1]]]), float(size[0])
    elif kind == kinds.mjGEOM_CYLINDER:
        angle = np.linspace(0.0, 2.0 * math.pi, 16, endpoint=False)
        ring = size[0] * np.column_stack([np.cos(angle), np.sin(angle)])
        own = np.array([[*each, z] for z in (size[1], -size[1]) for each in ring])
    elif kind == kinds.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_vertadr[mesh])
        own = np.array(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], float)
    else:
        middle, half = np.split(model.geom_aabb[geom], 2)
        own = middle + half * np.array(list(product((1.0, -1.0), repeat=3)))
    planes = model.geom_margin[(model.geom_bodyid == 0) & (model.geom_type == PLANE)]
    radius += float(model.geom_margin[geom] + planes.max(initial=0.0))
    return np.column_stack([own @ turn.T + place, np.full(len(own), radius)])
