"""What stands for links that nothing is drawn of: boxes with their mass and inertia."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from morph.app.picture.shapes import PictureShape
from morph.arrays import Array

COLOUR = (176, 132, 160)
"""Of no material, so that nobody takes it for what was described."""

OPACITY = 0.45
"""And translucent."""

LEAST = 1e-3
"""m: the least length of an edge."""


def placeholders(model: Any, drawn: set[int]) -> Iterator[PictureShape]:
    """Yield a box for each link of a `mujoco.MjModel` that has a mass and is not drawn."""
    for body in range(1, model.nbody):
        if body not in drawn and model.body_mass[body] > 0.0:
            yield _box(model, body)


def edges(mass: float, inertia: Array) -> Array:
    """Return the edges of the box that has a mass, kg, and principal inertias, kg m^2; m.

    With `I_x = m (y^2 + z^2) / 12` and so on, `x^2 = 6 (I_y + I_z - I_x) / m`.
    """
    square = 6.0 * (inertia.sum() - 2.0 * inertia) / mass
    return np.asarray(np.sqrt(np.maximum(square, LEAST**2)))


def _box(model: Any, body: int) -> PictureShape:
    from trimesh import creation

    box = creation.box(edges(float(model.body_mass[body]), model.body_inertia[body]))
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.body_iquat[body])
    return PictureShape(
        body=body,
        vertices=np.asarray(box.vertices @ turn.reshape(3, 3).T + model.body_ipos[body]),
        faces=np.asarray(box.faces, dtype=np.int64),
        colour=COLOUR,
        opacity=OPACITY,
        flat=True,
    )
