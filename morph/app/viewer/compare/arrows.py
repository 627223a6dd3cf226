"""Arrows of what acts on bodies: as long as the force is great, by one scale for each kind."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from morph.app.picture.scene import rounded
from morph.app.viewer.compare.forces import Forces
from morph.app.viewer.figure import Figure
from morph.app.viewer.motion import Motion
from morph.app.viewer.room import matrices
from morph.arrays import Array

KINDS = ("contact", "fluid", "buoyancy", "torque")
"""The kinds of arrows, as the stage names them."""

LONG = 0.5
"""How long a strong force is drawn, by the size of the largest body that feels one."""

STRONG = 95.0
"""Which force is strong: of a hundred, so many are weaker. A blow is stronger still."""

LONGEST = 1.5
"""What would be longer is cut, by the size of its body."""

SHORTEST = 0.01
"""What would be shorter is left out, likewise."""

FULL = 0.35
"""How long a motor's limit is drawn, by the size of its body."""


def size_of(figure: Figure, motion: Motion) -> float:
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


def scales(bodies: Sequence[tuple[Forces, float]]) -> Mapping[str, float]:
    """Return how many newtons a metre is, for each kind of force that there is.

    One scale for all bodies: a longer arrow is a greater force, whoever feels it.

    Args:
        bodies: What acted on each, and how large it is, m.
    """
    found = {}
    for kind in KINDS[:3]:
        felt = [(_strengths(getattr(forces, kind)), size) for forces, size in bodies]
        felt = [(strengths, size) for strengths, size in felt if len(strengths)]
        if felt:
            strong = float(np.percentile(np.concatenate([each for each, _ in felt]), STRONG))
            # A length is rounded down, so that the number of newtons is a round one.
            found[kind] = 1.0 / rounded(LONG * max(size for _, size in felt) / strong)
    return found


def arrows(forces: Forces, size: float, newtons: Mapping[str, float]) -> dict[str, Array]:
    """Return the arrows of one body by their kind, as a `Motion` holds them.

    Args:
        forces: What acted on it.
        size: How large it is, m.
        newtons: What `scales` gave.
    """
    found = {
        kind: _drawn(getattr(forces, kind), 1.0 / per_metre, size)
        for kind, per_metre in newtons.items()
        if getattr(forces, kind).shape[1]
    }
    if forces.drives:
        found["torque"] = _drawn(forces.torque, FULL * size / full_efforts(forces), size)
    return found


def full_efforts(forces: Forces) -> Array:
    """Return which effort of each driven joint is drawn in full length, shape (drives,).

    Its limit; where it has none, the greatest that it gave.
    """
    greatest = np.abs(forces.effort).max(axis=0, initial=1e-12)
    limits = [drive.limit or most for drive, most in zip(forces.drives, greatest, strict=True)]
    return np.array(limits, dtype=float)


def said(newtons: Mapping[str, float], *, driven: bool) -> dict[str, str]:
    """Return what the length of each kind of arrow means, in words."""
    words = {kind: f"{_round_length(per_metre)}" for kind, per_metre in newtons.items()}
    if driven:
        words["torque"] = f"along the joint's axis; the limit is {FULL:.0%} of the body's size"
    return words


def _round_length(per_metre: float) -> str:
    """Return what a length of 1, 10 or 100 cm is."""
    power = math.floor(math.log10(per_metre))
    if power >= 2:
        return f"1 cm is {per_metre / 100.0:.3g} N"
    if power >= 0:
        return f"10 cm is {per_metre / 10.0:.3g} N"
    return f"1 m is {per_metre:.3g} N"


def _strengths(forces: Array) -> Array:
    """Return how great forces are that are there and not nothing, N, shape (forces,)."""
    strengths = np.linalg.norm(forces[..., 1, :], axis=-1).ravel()
    most = np.nanmax(strengths, initial=0.0) if np.isfinite(strengths).any() else 0.0
    return strengths[np.isfinite(strengths) & (strengths > max(1e-3 * most, 1e-9))]


def _drawn(forces: Array, metres: Array | float, size: float) -> Array:
    """Return where arrows begin and end, m, of places and vectors (pictures, arrows, 2, 3)."""
    way = forces[..., 1, :] * np.reshape(metres, (-1, 1))
    length = np.linalg.norm(way, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        way = way * np.minimum(1.0, LONGEST * size / length)
        way = np.where(length < SHORTEST * size, np.nan, way)
    start = forces[..., 0, :]
    return np.stack([start, start + way], axis=-2).astype(np.float32)
