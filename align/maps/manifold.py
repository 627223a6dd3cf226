"""Manifold alignment: one embedding of both bodies, from pairs or from geometry alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import SamplesError, SettingError
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.follow import Following
from morph.alignment.maps.graph import alike, neighbours, patterns
from morph.alignment.maps.joint import across, together
from morph.alignment.maps.state_law import StateLaw, labelled, unscaled
from morph.alignment.scale import LEAST_SPREAD, scale

MOST = 150
"""Most states of a body that have a say in a graph."""


@dataclass(frozen=True, kw_only=True)
class Manifold(Following):
    """Neighbours of each body and states that are paired stay near in one embedding.

    Source: Wang and Mahadevan 2009, AAAI Fall Symposium on Manifold Learning, section 3 (alignment
    at the level of features, with correspondences).
    """

    name: ClassVar[str] = "manifold"
    needs: ClassVar[frozenset[str]] = frozenset({"pairs"})

    nearest: int = 8
    """How many neighbours a state has."""
    weight: float = 30.0
    """What all pairs together weigh against all neighbours of both bodies together."""

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        check_graph(self.nearest, self.weight, where=f"map {self.name}")

    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return the law by which both embeddings are one."""
        return aligned(
            given, rng, nearest=self.nearest, weight=self.weight, free=0.0, where=self.name
        )


@dataclass(frozen=True, kw_only=True)
class ManifoldFree(Following):
    """As above, but what corresponds is told by how alike the neighbourhoods are; no pairs.

    Neighbourhoods of a body that is its own mirror image are the same on both sides: no sign of
    a direction can be known, and the controls show it.

    Source: Wang and Mahadevan 2009, IJCAI (manifold alignment without correspondence).
    """

    name: ClassVar[str] = "manifold_free"

    nearest: int = 4
    """How many neighbours a pattern has; all their orders are tried."""
    weight: float = 1.0
    """What alikeness of both bodies weighs against the neighbours of both bodies."""

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        check_graph(self.nearest, self.weight, where=f"map {self.name}")

    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return the law by which both embeddings are one."""
        return aligned(
            given, rng, nearest=self.nearest, weight=0.0, free=self.weight, where=self.name
        )


def check_graph(nearest: int, weight: float, *, where: str) -> None:
    """Check the settings of a graph.

    Raises:
        SettingError: One is out of range.
    """
    if not (2 <= nearest <= 20 and weight > 0.0):
        raise SettingError(
            f"a state has {nearest} neighbours, and pairs weigh {weight:g}",
            where=where,
            fix="give 2 to 20 neighbours and a positive weight",
        )


def some(states: Array, rng: np.random.Generator, *, least: int, where: str) -> Array:
    """Return at most `MOST` rows of states, chosen by chance.

    Raises:
        SamplesError: There are fewer than the least, or the body never moved.
    """
    if len(states) < least or states.std(axis=0).max() <= LEAST_SPREAD:
        raise SamplesError(
            f"a body was seen in {len(np.unique(states, axis=0))} states",
            where=f"map {where}",
            fix=f"give at least {least}, of a body that moves",
        )
    return np.asarray(states[rng.permutation(len(states))[:MOST]])


def aligned(
    given: MapData,
    rng: np.random.Generator,
    *,
    nearest: int,
    weight: float,
    free: float,
    where: str,
    geometry: int = 4,
) -> StateLaw:
    """Return the map of states by a joint embedding.

    Args:
        given: Both bodies, and pairs if they have a weight.
        rng: The chance of which states have a say.
        nearest: Neighbours in the graphs.
        weight: What all pairs weigh against all neighbours; 0 for no pairs.
        free: What alikeness of local geometry weighs against all neighbours; 0 for none.
        where: The map's name.
        geometry: Neighbours in a local pattern.
    """
    ours, theirs = scale(given.source.state), scale(given.target.state)
    least = max(nearest, geometry) + 2
    x = ours(some(given.source.state, rng, least=least, where=where))
    y = theirs(some(given.target.state, rng, least=least, where=where))
    tied = np.zeros((len(x), len(y)))
    near_x, near_y = neighbours(x, nearest), neighbours(y, nearest)
    total = 0.5 * float(near_x.sum() + near_y.sum())
    if free:
        tied = alike(patterns(x, geometry), patterns(y, geometry))
        tied *= free * total / float(tied.sum())
    shift = np.zeros(len(ours.spread))
    if weight:
        pairs = labelled(given, where=f"map {where}")
        a, b = ours(pairs.source), theirs(pairs.target)
        k = len(a)
        x, y = np.concatenate([x, a]), np.concatenate([y, b])
        near_x, near_y = neighbours(x, nearest), neighbours(y, nearest)
        tied = np.pad(tied, ((0, k), (0, k)))
        tied[-k:, -k:] += weight * total / k * np.eye(k)
    S = across(*together(x, y, near_x, near_y, tied, len(ours.spread)), where=f"map {where}")
    if weight:
        # The clouds' middles need not correspond; the pairs say by how much they do not.
        shift = (a - b @ S.T).sum(axis=0) / (k + 1)
    return unscaled(S, shift, ours, theirs)
