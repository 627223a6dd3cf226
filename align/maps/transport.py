"""Optimal transport: states go where their distances to all others stay what they are."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import SettingError
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.follow import Following
from morph.alignment.maps.manifold import some
from morph.alignment.maps.state_law import StateLaw, labelled, unscaled
from morph.alignment.regression import apart
from morph.alignment.scale import scale


@dataclass(frozen=True, kw_only=True)
class Transport(Following):
    """A plan that keeps distances within each body, and with pairs distances to landmarks.

    The map is the affine one that is nearest to where the plan takes each state. Without pairs
    it is Gromov-Wasserstein, which cannot tell a body from its mirror image.

    Source: Memoli 2011, Foundations of Computational Mathematics 11; with landmarks Vayer, Chapel,
    Flamary, Tavenard and Courty 2020, Algorithms 13(9) (fused Gromov-Wasserstein).
    """

    name: ClassVar[str] = "transport"

    shape: float = 0.3
    """What the shape counts where there are landmarks, 0 to 1; they count the rest."""
    most: int = 120
    """Most states of a body that are transported."""

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        if not (0.0 < self.shape <= 1.0 and 10 <= self.most <= 500):
            raise SettingError(
                f"the shape counts {self.shape:g}, for at most {self.most} states",
                where=f"map {self.name}",
                fix="let it count more than 0 and at most 1, for 10 to 500 states",
            )

    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return the affine map that is nearest to the plan."""
        ours, theirs = scale(given.source.state), scale(given.target.state)
        least = len(theirs.spread) + 2
        x = ours(some(given.source.state, rng, least=least, where=self.name)[: self.most])
        y = theirs(some(given.target.state, rng, least=least, where=self.name)[: self.most])
        within = [np.sqrt(apart(each, each)) for each in (y, x)]
        within = [each / each.mean() for each in within]
        if given.pairs is None:
            goal, start = y, y
            cost, shape = np.zeros((len(y), len(x))), 1.0
        else:
            pairs = labelled(given, where=f"map {self.name}")
            a, b = ours(pairs.source), theirs(pairs.target)
            far = [np.sqrt(apart(y, b)), np.sqrt(apart(x, a))]
            cost, shape = apart(*(each / each.mean() for each in far)) / len(a), self.shape
        plan = fused(cost, within[0], within[1], shape)
        goal = (plan @ x) / plan.sum(axis=1, keepdims=True)
        start = y
        if given.pairs is not None:
            share = int(np.ceil(3.0 * len(y) / len(b)))
            start = np.concatenate([y, np.repeat(b, share, axis=0)])
            goal = np.concatenate([goal, np.repeat(a, share, axis=0)])
        columns = np.column_stack([start, np.ones(len(start))])
        price = 1e-3 * len(columns) * np.eye(columns.shape[1])
        result = np.linalg.solve(columns.T @ columns + price, columns.T @ goal).T
        return unscaled(result[:, :-1], result[:, -1], ours, theirs)


def fused(cost: Array, ours: Array, theirs: Array, shape: float) -> Array:
    """Return the plan between two sets of points of equal weights, by their distances.

    Args:
        cost: What it costs to take one to another, shape (m, k).
        ours: Distances within the first, shape (m, m).
        theirs: Distances within the second, shape (k, k).
        shape: What the distances count, 0 to 1; the cost counts the rest.
    """
    # Only numpy's backend is asked for: looking for others would load torch and more.
    for backend in ("PYTORCH", "JAX", "TENSORFLOW", "CUPY"):
        os.environ.setdefault(f"POT_BACKEND_DISABLE_{backend}", "1")
    from ot.gromov import fused_gromov_wasserstein

    p, q = (np.full(len(each), 1.0 / len(each)) for each in (ours, theirs))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        plan = fused_gromov_wasserstein(cost, ours, theirs, p, q, "square_loss", alpha=shape)
    return np.asarray(plan, dtype=float)
