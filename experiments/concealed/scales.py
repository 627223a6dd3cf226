"""Typical sizes along the runs, by which the figures of laws are chosen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.concealed.plant import Array, Plant
from experiments.concealed.simulate import Motion


@dataclass(frozen=True, kw_only=True)
class Scales:
    """Sizes of each joint's motion, shape (joints,) each."""

    effort: Array
    """RMS of the force that moves the joint, N m or N."""
    peak: Array
    """Largest force of its drive, N m or N."""
    speed: Array
    """RMS velocity."""
    fast: Array
    """Largest velocity."""
    spread: Array
    """Standard deviation of its position."""
    middle: Array
    """Mean position."""
    low: Array
    """Lowest position."""
    high: Array
    """Highest position."""
    inertia: Array
    """Inertia that it moves, its rotor included, kg m2 or kg."""
    pair: Array
    """Inertia of rotor and link against each other: Jr Jl / (Jr + Jl)."""


def scales_of(plant: Plant, motions: Sequence[Motion], every: int = 40) -> Scales:
    """Return the sizes along motions, looked at every `every` steps."""
    q = np.concatenate([m.q[::every] for m in motions])
    v = np.concatenate([m.v[::every] for m in motions])
    a = np.concatenate([np.gradient(m.v[::every], m.step * every, axis=0) for m in motions])
    mass, bias = plant.mass_and_bias(q, v)
    rotor = plant.of_joint("rotor")
    force = np.einsum("tij,tj->ti", mass, a) + bias + rotor * a
    link = np.einsum("tii->ti", mass).mean(axis=0)
    effort = np.sqrt((force**2).mean(axis=0))
    # A joint that gravity does not load and nothing drives still feels its own inertia.
    effort = np.maximum(effort, 0.05 * (link + rotor) * v.std(axis=0) * 6.0 + 1e-6)
    return Scales(
        effort=effort,
        peak=np.abs(force).max(axis=0),
        speed=np.sqrt((v**2).mean(axis=0)) + 1e-6,
        fast=np.abs(v).max(axis=0) + 1e-6,
        spread=q.std(axis=0) + 1e-6,
        middle=q.mean(axis=0),
        low=q.min(axis=0),
        high=q.max(axis=0),
        inertia=link + rotor,
        pair=rotor * link / (rotor + link),
    )
