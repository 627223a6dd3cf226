"""Arrows of what acts on bodies, told by what each can bear: its own weight, its motors' limits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from morph.app.picture.scene import rounded
from morph.app.viewer.compare.forces import Forces
from morph.app.viewer.figure import Figure
from morph.app.viewer.motion import MotionFrames
from morph.app.viewer.swept_bounds import matrices
from morph.arrays import Array

FORCES = ("contact", "fluid", "buoyancy")
"""The kinds of arrows that are forces, as the stage names them."""

KINDS = (*FORCES, "torque")
"""All kinds."""

LONG = 0.5
"""How long a strong one is drawn, by the size of its body."""

STRONG = 80.0
"""Which one is strong: of a hundred, so many are weaker; a blow is much stronger."""

LONGEST = 1.5
"""What would be longer is cut, by the size of its body."""

SHORTEST = 0.01
"""What would be shorter is left out, likewise."""

WIDEST = 3e-3
"""Least share of a weight or a limit that is drawn long: what is less is nothing."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Felt:
    """What acted on one body, and what it is measured by."""

    forces: Forces
    """What acted on it."""
    weight: float
    """Its weight, N."""
    size: float
    """How large it is, m."""

    def shares(self, kind: str) -> Array:
        """Return arrows as shares of weight or limit, (pictures, arrows, 3)."""
        vectors = getattr(self.forces, kind)[..., 1, :]
        if kind in FORCES:
            return np.asarray(vectors / self.weight)
        return np.asarray(vectors / self._efforts[:, None])

    @property
    def _efforts(self) -> Array:
        """Each driven joint's limit; where it has none, the greatest effort that it gave."""
        greatest = np.abs(self.forces.effort).max(axis=0, initial=1e-12)
        drives = zip(self.forces.drives, greatest, strict=True)
        return np.array([drive.limit or most for drive, most in drives], dtype=float)


def size_of(figure: Figure, motion: MotionFrames) -> float:
    """Return how large a body is in the first picture, m: the diagonal of its upright box."""
    turned = matrices(motion.turn[0])
    corners = [
        turned[shape.body] @ end + motion.position[0, shape.body]
        for shape in figure.shapes
        if shape.body
        for end in shape.vertices[:: max(1, len(shape.vertices) // 50)]
    ]
    points = np.array(corners) if corners else motion.position[0]
    return float(np.linalg.norm(np.ptp(points, axis=0))) or 0.1


def scales(bodies: Sequence[Felt]) -> Mapping[str, float]:
    """Return which share of weight or limit is drawn `LONG`, for each kind that there is.

    One scale for all bodies, by what each of them can bear: an arrow twice as long, by its
    body's size, is twice as much of that body's weight. A small body's are so seen as well.
    """
    results = {}
    for kind in KINDS:
        strong = [_strengths(felt.shares(kind)) for felt in bodies]
        every = np.concatenate([np.zeros(0), *strong])
        if len(every):
            share = max(WIDEST, float(np.percentile(every, STRONG, method="lower")))
            # 1 over a rounded number is a round one, too: 1, 2 or 5 times a power of ten.
            results[kind] = 1.0 / rounded(1.0 / share)
    return results


def arrows(felt: Felt, full: Mapping[str, float]) -> dict[str, Array]:
    """Return the arrows of one body by their kind, as a `MotionFrames` holds them.

    Args:
        felt: What acted on it.
        full: What `scales` gave.
    """
    return {
        kind: _drawn(
            getattr(felt.forces, kind)[..., 0, :],
            felt.shares(kind) * (LONG * felt.size / share),
            felt.size,
        )
        for kind, share in full.items()
        if getattr(felt.forces, kind).shape[1]
    }


def said(full: Mapping[str, float]) -> dict[str, str]:
    """Return what the length of each kind of arrow means, in words."""
    return {
        kind: f"half the body's size is {_share(share)}"
        + ("the body's weight" if kind in FORCES else "the motor's limit")
        for kind, share in full.items()
    }


def _share(share: float) -> str:
    if math.isclose(share, 1.0):
        return ""
    return f"{100.0 * share:.3g} % of " if share < 1.0 else f"{share:.3g} times "


def _strengths(shares: Array) -> Array:
    """Return how great arrows are that are there and not nothing, shape (arrows,)."""
    strengths = np.linalg.norm(shares, axis=-1).ravel()
    strengths = strengths[np.isfinite(strengths)]
    return np.asarray(strengths[strengths > max(1e-3 * strengths.max(initial=0.0), 1e-9)])


def _drawn(start: Array, way: Array, size: float) -> Array:
    """Return where arrows begin and end, m, shape (pictures, arrows, 2, 3)."""
    length = np.linalg.norm(way, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        way = way * np.minimum(1.0, LONGEST * size / length)
        way = np.where(length < SHORTEST * size, np.nan, way)
    return np.stack([start, start + way], axis=-2).astype(np.float32)
