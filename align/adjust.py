"""From commands and those that replicate them on a target to what is to be added to a policy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array, Mask
from morph.alignment.errors import SamplesError
from morph.alignment.regression import apart, regression
from morph.alignment.states import features


@dataclass(frozen=True, kw_only=True, eq=False)
class Adjustment:
    """d of pi_adj(x, u) = u + d(f(x), u): a linear law, and radial functions that fade out.

    With z = (f(x), u), d = b + W z + sum over i of w_i exp(-|(z - c_i) / s|^2 / 2); f(x) is what
    does not turn and then sine and cosine of each angle. The law goes on where nothing was seen,
    up to the most that was seen; the rest is 0 there.

    Source: Gamboa Higuera 2015, section 3.3, steps 4 and 5.
    """

    turns: Mask
    """Which numbers of a state are angles, shape (n,)."""
    bias: Array
    """b, shape (nu,)."""
    law: Array
    """W, shape (nu, d)."""
    centre: Array
    """c, shape (units, d)."""
    width: Array
    """s of each command, shape (nu, d)."""
    weight: Array
    """w, shape (nu, units)."""
    reach: Array
    """Most |z| for which the law holds; beyond it is taken to be there, shape (d,)."""

    def __call__(self, state: Array, command: Array) -> Array:
        """Return what is added to commands (m, nu) at states (m, n), shape (m, nu)."""
        return self.sloped(state, command)[0]

    def sloped(self, state: Array, command: Array) -> tuple[Array, Array]:
        """Return what is added, (m, nu), and its derivative in the commands, (m, nu, nu)."""
        z = np.concatenate([features(state, self.turns), command], axis=1)
        held = np.clip(z, -self.reach, self.reach)
        result = held @ self.law.T + self.bias
        commanded = np.arange(z.shape[1] - command.shape[1], z.shape[1])
        slope = np.where((held == z)[:, None, commanded], self.law[:, commanded], 0.0)
        for at, (width, weight) in enumerate(zip(self.width, self.weight, strict=True)):
            here, there = z / width, self.centre / width
            near = np.exp(-0.5 * apart(here, there)) * weight
            total = near.sum(axis=1)
            result[:, at] += total
            pull = near @ there[:, commanded] - total[:, None] * here[:, commanded]
            slope[:, at] += pull / width[commanded]
        return np.asarray(result), np.asarray(slope)

    def times(self, factor: float) -> Adjustment:
        """Return so much of it; -1 turns its sign, as controls do."""
        return Adjustment(
            turns=self.turns,
            bias=factor * self.bias,
            law=factor * self.law,
            centre=self.centre,
            width=self.width,
            weight=factor * self.weight,
            reach=self.reach,
        )


BEYOND = 1.5
"""The law holds for numbers up to so many times the greatest that were seen."""


def adjustment(
    state: Array,
    command: Array,
    replicating: Array,
    turns: Mask,
    variance: Array | None = None,
) -> Adjustment:
    """Return what is to be added to commands so that a target does what a source did.

    Args:
        state: x, shape (m, n).
        command: What the source's policy commands there, shape (m, nu).
        replicating: What makes the target do what that does on the source, shape (m, nu).
        turns: Which numbers of a state are angles, shape (n,).
        variance: How uncertain `replicating` is, shape (m, nu); None if it is not.

    Raises:
        SamplesError: The data are too few, too many, unequal in number, or no numbers.
    """
    if command.shape != replicating.shape or command.ndim != 2:
        raise SamplesError(
            f"commands have the shape {command.shape}, those that replicate them "
            f"{replicating.shape}",
            where="the data of an adjustment",
            fix="give both the shape (m, nu)",
        )
    z = np.concatenate([features(state, turns), command], axis=1)
    wanted = replicating - command
    known = np.zeros_like(wanted) if variance is None else variance
    parts = [regression(z, each, sure) for each, sure in zip(wanted.T, known.T, strict=True)]
    return Adjustment(
        turns=turns,
        bias=np.array([part.linear[0] for part in parts]),
        law=np.stack([part.linear[1:] for part in parts]),
        centre=z,
        width=np.stack([part.bumps[1] for part in parts]),
        weight=np.stack([part.bumps[2] for part in parts]),
        reach=BEYOND * np.abs(z).max(axis=0),
    )
