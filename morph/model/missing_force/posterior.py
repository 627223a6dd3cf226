"""What runs say of a body's figures and of a force on it, once the states are taken out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.model.gaussian.information import Information
from morph.model.gaussian.states import ReducedEquations, Trust, band
from morph.model.missing_force.periods import PeriodSlopes

FLOOR = 0.02
"""Least unexplained jump of a state in a period, in standard deviations of its noise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reduced:
    """What a run says of h = (p, f_1 .. f_T), the states taken out, with all constants."""

    information: Information
    """Of h."""
    band: ReducedEquations
    """The states' normal equations about where the slopes were taken."""
    size: int
    """How many numbers p has."""
    about: Array
    """h where the slopes were taken."""

    def states(self, h: Array) -> Array:
        """Return how far the likeliest states are from where the slopes were taken; (T + 1, n)."""
        return self.band.states(h - self.about)

    def through(self, features: Array) -> Information:
        """Return what it says of (p, weights), for mean features (periods, joints, count)."""
        periods, joints, count = features.shape
        map_ = np.zeros((len(self.about), self.size + joints * count))
        map_[: self.size, : self.size] = np.eye(self.size)
        inner = map_[self.size :, self.size :].reshape(periods, joints, joints, count)
        for joint in range(joints):
            inner[:, joint, joint] = features[:, joint]
        return self.information.through(map_)


def jump_variance(jump: Array, noise: Array, period: float) -> Array:
    """Return the variance of what no force explains in a period, shape (n,).

    White forces through a period h that change a velocity by the standard deviation r leave the
    place r h / sqrt(3) off; a little is added, as without it states would be tied too stiffly.

    Args:
        jump: r of each velocity, shape (joints,).
        noise: Standard deviation of each state's noise, shape (n,).
        period: h, s.
    """
    place = jump * period / np.sqrt(3.0)
    return np.asarray(np.concatenate([place, jump]) ** 2 + (FLOOR * noise) ** 2)


def reduced(slopes: PeriodSlopes, seen: Array, noise: Array, jump: Array) -> Reduced:
    """Return what a run says of (p, f), the states taken out.

    With y = x + noise and x_{t+1} = F(x_t, u_t; p, f_t) + jump, linearised about what is believed,
    the states' normal equations are banded. An observation's noise enters two transitions, and
    what it does to both is counted as what it is: one noise.

    Args:
        slopes: The run, linearised.
        seen: y, shape (periods + 1, n).
        noise: Its standard deviations, shape (n,).
        jump: Variances of the jumps, shape (n,).
    """
    count, n, size = slopes.of_point.shape
    joints = slopes.of_force.shape[2]
    # How period t answers to p and to its own force.
    unknown = np.zeros((count, n, size + count * joints))
    unknown[:, :, :size] = slopes.of_point
    for at in range(count):
        unknown[at, :, size + at * joints : size + (at + 1) * joints] = slopes.of_force[at]
    trust = Trust(seen=1.0 / noise**2, moved=1.0 / jump)
    result = band(
        state=slopes.of_state, unknown=unknown, off=slopes.missed,
        missed=seen - slopes.state, trust=trust,
    )  # fmt: skip
    about = np.concatenate([slopes.point, slopes.force.ravel()])
    constant = (count + 1) * float(np.log(noise**2).sum()) + count * float(np.log(jump).sum())
    whole = result.information.about(about)
    information = replace(whole, c=whole.c + constant)
    return Reduced(information=information, band=result, size=size, about=about)
