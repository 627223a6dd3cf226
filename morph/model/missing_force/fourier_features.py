"""Random Fourier features of a state: a Gaussian process force in finite dimensions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from morph.arrays import Array, Integers

OWN = 16
"""Waves of a joint's own velocity, each a sine and a cosine."""

FASTEST = 20.0
"""Frequency, over one length, beyond which one wave stands for all that are faster."""

WHOLE = 32
"""Waves of all that is looked at, likewise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FourierFeatures:
    """Features of a state for each joint, those of its own velocity first.

    The force on joint j is a Gaussian process with the covariance

        s_j^2 (exp(-|v_j - v_j'| / (r_j l)) + v_j v_j' / r_j^2) + z_j^2 exp(-|e - e'|^2 / (2 m^2)),

    with e the cosines and sines of the angles and all velocities over their sizes r. The first
    kernel is rough, as dry friction jumps where a joint turns back; the second is smooth. Each is
    the mean of products of waves with frequencies of its spectrum: Cauchy's for the first, cut into
    intervals that grow, each with its share, and a normal distribution for the second, drawn once.

    Source: Rahimi and Recht 2007, NeurIPS 20, algorithm 1; Rasmussen and Williams 2006, eqs. 4.14
    and 4.9 (with p = 0).
    """

    hinges: Integers
    """Where the angles stand in a state, shape (hinges,)."""
    slides: Integers
    """Where the slides stand whose places matter, shape (slides,)."""
    joints: int
    """How many numbers a velocity has; a state is a position, then a velocity, of as many."""
    size: Array
    """r: typical sizes of the slides' places, then of the velocities, shape (slides + joints,)."""
    own_length: float
    """l, in sizes."""
    length: float
    """m, in sizes; of cosines and sines 1 is one."""
    farthest: Array
    """Least and greatest place and velocity that were seen, shape (2, slides + joints): beyond,
    the force stays what it is there, as a sum of waves means nothing where no data are."""
    seed: int = 0
    """Chance of the smooth kernel's frequencies."""

    @property
    def count(self) -> int:
        """How many features each joint has."""
        return 2 * OWN + 1 + 2 * WHOLE

    @property
    def own(self) -> int:
        """How many of them are of its own velocity; they come first."""
        return 2 * OWN + 1

    @cached_property
    def _frequencies(self) -> tuple[Array, Array, Array]:
        """Frequencies of a joint's own velocity, their amplitudes, and those of the whole."""
        edge = FASTEST * np.sinh(3.0 * np.arange(OWN + 1) / OWN) / np.sinh(3.0)
        share = np.arctan(edge) / (0.5 * np.pi)
        share[-1] = 1.0
        middle = np.tan(0.25 * np.pi * (share[1:] + share[:-1]))
        numbers = 2 * len(self.hinges) + len(self.slides) + self.joints
        drawn = np.random.default_rng(self.seed).normal(size=(numbers, WHOLE))
        return middle / self.own_length, np.sqrt(np.diff(share)), drawn / self.length

    def of(self, state: Array) -> Array:
        """Return the features of states (..., 2 joints), shape (..., joints, count)."""
        own, amplitude, whole = self._frequencies
        places = len(self.slides)
        low, high = self.farthest
        velocity = np.clip(state[..., self.joints :], low[places:], high[places:])
        speed = velocity / self.size[places:]
        angle = state[..., self.hinges]
        place = np.clip(state[..., self.slides], low[:places], high[:places]) / self.size[:places]
        looked = np.concatenate([np.cos(angle), np.sin(angle), place, speed], axis=-1)
        alone = speed[..., None] * own
        together = looked @ whole
        shared = np.concatenate([np.cos(together), np.sin(together)], axis=-1) / np.sqrt(WHOLE)
        result = np.empty((*speed.shape, self.count))
        result[..., :OWN] = amplitude * np.cos(alone)
        result[..., OWN : 2 * OWN] = amplitude * np.sin(alone)
        result[..., 2 * OWN] = speed
        result[..., self.own :] = shared[..., None, :]
        return result

    def with_lengths(self, own_length: float, length: float) -> FourierFeatures:
        """Return the same with other lengths."""
        return replace(self, own_length=own_length, length=length)

    def variances(self, own: Array, whole: Array) -> Array:
        """Return the prior variance of each weight, shape (joints, count).

        Args:
            own: s, standard deviation of each joint's rough part, shape (joints,).
            whole: z, of its smooth part, shape (joints,).
        """
        rough = np.repeat(own[:, None] ** 2, self.own, axis=1)
        smooth = np.repeat(whole[:, None] ** 2, 2 * WHOLE, axis=1)
        return np.concatenate([rough, smooth], axis=1)


def waves_of(kinds: Sequence[str], states: Array, *, slides: bool) -> FourierFeatures:
    """Return the waves of a body, their sizes from states that were seen.

    Args:
        kinds: `hinge` or `slide`, of each joint.
        states: Shape (samples, 2 joints).
        slides: Whether it matters where slides are.
    """
    joints = len(kinds)
    places = np.flatnonzero([kind == "slide" and slides for kind in kinds])
    which = np.concatenate([places, joints + np.arange(joints)]).astype(np.int64)
    return FourierFeatures(
        hinges=np.flatnonzero([kind == "hinge" for kind in kinds]),
        slides=places,
        joints=joints,
        size=np.maximum(states[:, which].std(axis=0), 1e-6),
        own_length=1.0,
        length=1.0,
        farthest=np.stack([states[:, which].min(axis=0), states[:, which].max(axis=0)]),
    )
