"""Arrows of one kind of one body; a short one is slender, so that it still is an arrow."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from morph.app.viewer.colour import linear
from morph.app.viewer.content import Colour
from morph.arrays import Array, Integers

SHAFT = 0.006
"""Radius of a long arrow's shaft, by the size of its body."""

HEAD_RADIUS, HEAD_LENGTH = 2.6, 7.0
"""Of its head, by the radius of its shaft."""

MOST_HEAD = 0.4
"""Part of an arrow that its head takes at the most."""

SHRINK, STEPS = 0.6, 9
"""A shorter one is drawn in one of so many steps, each so much more slender than the last."""


class Quiver:
    """The arrows.

    Args:
        scene: A `viser.SceneApi`.
        name: Where they stand in the scene.
        arrows: From and to, m, shape (pictures, arrows, 2, 3); NaN for what is not there.
        size: How large the body is, m.
        colour: Of all.
    """

    def __init__(self, scene: Any, name: str, arrows: Array, size: float, colour: Colour) -> None:
        """Put them on the scene, all out of sight; `pose` must follow."""
        self._arrows, self._step = arrows, steps(arrows, size)
        self._nodes: dict[int, Any] = {}
        # One node has one thickness.
        for step in np.unique(self._step[self._step >= 0]).tolist():
            shaft = SHAFT * size * SHRINK**step
            self._nodes[step] = scene.add_arrows(
                f"{name}/{step}",
                np.zeros((1, 2, 3), dtype=np.float32),
                linear(colour),
                shaft_radius=shaft,
                head_radius=HEAD_RADIUS * shaft,
                head_length=HEAD_LENGTH * shaft,
                visible=False,
            )

    def pose(self, picture: int, *, shown: bool) -> None:
        """Show those of a picture, or none."""
        step, arrows = self._step[picture], self._arrows[picture]
        for each, node in self._nodes.items():
            there = arrows[step == each] if shown else arrows[:0]
            if len(there):
                node.points = there.astype(np.float32)
            node.visible = len(there) > 0


def steps(arrows: Array, size: float) -> Integers:
    """Return how slender each arrow is, in steps, shape (pictures, arrows); -1 for none at all."""
    length = np.linalg.norm(arrows[..., 1, :] - arrows[..., 0, :], axis=-1)
    there = np.isfinite(arrows).all(axis=(-2, -1)) & (length > 0.0)
    head = SHAFT * HEAD_LENGTH * size
    with np.errstate(divide="ignore", invalid="ignore"):
        result = np.ceil(np.log(head / (MOST_HEAD * length)) / -math.log(SHRINK) - 1e-9)
    return np.where(there, np.clip(np.nan_to_num(result), 0, STEPS - 1), -1).astype(np.int64)
