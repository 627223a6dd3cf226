"""Maps learned, and the controls beside them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.maps import mapper
from morph.arrays import Array

Read = Callable[[Array, Array], tuple[Array, Array]]
"""From states and commands of a target to what they are taken for."""


def shuffled(given: MapData, rng: np.random.Generator) -> MapData:
    """Return the same with the target's next states in another order: nothing follows."""
    target = given.target
    return replace(given, target=replace(target, after=rng.permutation(target.after)))


def learned(name: str) -> Callable[[MapData, np.random.Generator], Read]:
    """Return what reads by a map of the family that has this name."""

    def estimate(given: MapData, rng: np.random.Generator) -> Read:
        body_map = mapper(name).fit(given, rng)
        return lambda y, a: (body_map.state(y), body_map.action_back(y, a))

    return estimate


def lost(given: MapData, rng: np.random.Generator) -> Read:
    """Return what reads by the map of curves learned from shuffled transitions."""
    return learned("transition_kernel")(shuffled(given, rng), rng)


def principal(given: MapData, rng: np.random.Generator) -> Read:
    """Return what takes principal components for each other, the greatest for the greatest."""
    state = _principal(given.source.state, given.target.state)
    command = _principal(given.source.command, given.target.command)
    return lambda y, a: (state(y), command(a))


def _principal(source: Array, target: Array) -> Callable[[Array], Array]:
    middle, ours = source.mean(axis=0), _axes(source)
    there, theirs = target.mean(axis=0), _axes(target / target.std(axis=0))
    law = ours @ np.linalg.pinv(theirs[:, : ours.shape[1]]) / target.std(axis=0)
    return lambda x: np.asarray(middle + (x - there) @ law.T)


def _axes(x: Array) -> Array:
    value, vector = np.linalg.eigh(np.cov(x.T).reshape(x.shape[1], x.shape[1]))
    return np.asarray((vector * np.sqrt(np.maximum(value, 1e-12)))[:, ::-1])


def any_order(given: MapData, rng: np.random.Generator) -> Read:
    """Return what takes the target's numbers for the source's in any order, with any signs."""
    state = _any(given.source.state, given.target.state, rng)
    command = _any(given.source.command, given.target.command, rng)
    return lambda y, a: (state(y), command(a))


def _any(source: Array, target: Array, rng: np.random.Generator) -> Callable[[Array], Array]:
    chosen = rng.permutation(target.shape[1])[: source.shape[1]]
    scale = source.std(axis=0) / target.std(axis=0)[chosen]
    scale = scale * rng.choice([-1.0, 1.0], size=len(scale))
    middle, there = source.mean(axis=0), target.mean(axis=0)[chosen]
    return lambda x: np.asarray(middle + scale * (x[:, chosen] - there))


WAYS: dict[str, Callable[[MapData, np.random.Generator], Read]] = {
    "transition_kernel": learned("transition_kernel"),
    "transition": learned("transition"),
    "transition_network": learned("transition_network"),
    "shuffled": lost,
    "principal": principal,
    "any_order": any_order,
}
"""By name; from `shuffled` on they are controls."""
