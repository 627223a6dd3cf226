"""Affine maps of states alone, and what the ways to learn one from pairs share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError, SamplesError
from morph.alignment.maps.body_map import MapData
from morph.alignment.samples import Pairs
from morph.alignment.scale import Standardizer


@dataclass(frozen=True, kw_only=True, eq=False)
class StateLaw:
    """x = S y + s."""

    S: Array
    """Shape (n_s, n_t)."""
    s: Array
    """Shape (n_s,)."""

    def __call__(self, target: Array) -> Array:
        """Return what the target's states (m, n_t) are to the source, shape (m, n_s)."""
        return np.asarray(target @ self.S.T + self.s)


def unscaled(law: Array, shift: Array, source: Standardizer, target: Standardizer) -> StateLaw:
    """Return in the bodies' units what z_s = law z_t + shift is in spreads."""
    S = source.spread[:, None] * law / target.spread
    return StateLaw(S=S, s=source.back(shift) - S @ target.middle)


def labelled(given: MapData, *, where: str) -> Pairs:
    """Return the pairs that a map is learned from.

    Raises:
        MapError: There are none.
        SamplesError: They are states of other bodies than the transitions.
    """
    if given.pairs is None or not len(given.pairs.source):
        raise MapError(
            "it is given no pair",
            where=where,
            fix="label a few states of both bodies that correspond",
        )
    results = (given.pairs.source.shape[1], given.pairs.target.shape[1])
    wanted = (given.source.state.shape[1], given.target.state.shape[1])
    if results != wanted:
        raise SamplesError(
            f"states of the pairs have {results[0]} and {results[1]} numbers",
            where=where,
            fix=f"give {wanted[0]} of the source and {wanted[1]} of the target",
        )
    return given.pairs


def components(z: Array, count: int) -> Array:
    """Return the leading principal directions of centred data (m, n), shape (n, count)."""
    axes = np.linalg.svd(z - z.mean(axis=0), full_matrices=False)[2]
    return np.asarray(axes[:count].T)


def ridged(inputs: Array, outputs: Array, ridge: float) -> tuple[Array, Array]:
    """Return the law W and the rest b of outputs = W inputs + b by ridge regression.

    Slopes are drawn to 0; the rest is drawn to 0 as by one more row of zeros, since both bodies
    are scaled about their own middle.

    Args:
        inputs: Shape (m, d).
        outputs: Shape (m, k).
        ridge: What a slope of 1 costs, as a share of the rows.
    """
    m, d = inputs.shape
    z = np.concatenate([inputs, np.ones((m, 1))], axis=1)
    price = np.diag([*[ridge * m] * d, 1.0])
    result = np.linalg.solve(z.T @ z + price, z.T @ outputs)
    return np.asarray(result[:d].T), np.asarray(result[d])
