"""Penetration depth of contacts at the start of a simulation."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array

DEEP = 0.005
"""A contact that begins deeper than this, m, is no footing: the solver throws it out."""


def buried(model: Any, position: Array) -> str:
    """Return in words what begins deep within what it touches, or nothing.

    Args:
        model: The `mujoco.MjModel` that is to move.
        position: MuJoCo's `qpos` at the start, shape (nq,).
    """
    data = mujoco.MjData(model)
    data.qpos[:] = position
    mujoco.mj_fwdPosition(model, data)
    if not data.ncon or data.contact.dist.min() > -DEEP:
        return ""
    worst = int(np.argmin(data.contact.dist))
    # The world's shape last.
    pair = sorted(data.contact.geom[worst], key=lambda geom: model.geom_bodyid[geom] == 0)
    one, two = (_name(model, int(geom)) for geom in pair)
    return (
        f"it begins with {one} and {two} {-1e3 * data.contact.dist[worst]:.3g} mm within each "
        "other, and is thrown apart: start it where they touch at most"
    )


def _name(model: Any, geom: int) -> str:
    """Return the link that a shape belongs to, or the shape of the world."""
    body = int(model.geom_bodyid[geom])
    return str(model.body(body).name if body else model.geom(geom).name or "the world")
