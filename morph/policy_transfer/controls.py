"""What a transfer is held against: the same policy through maps that are wrong on purpose."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np

from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import BodyMap
from morph.arrays import Array, Integers
from morph.policy_transfer.body import Body, Law

SHUFFLES = 3
"""Shuffled maps over which the mean is taken."""

MOST_WAYS = 6
"""Coordinates up to which every order is known; beyond, orders are drawn."""


def through(body_map: BodyMap, gain: Array, shift: Array) -> Law:
    """Return the law of a target that sees itself through a map as the source it moves.

    Args:
        body_map: The map.
        gain: Of the source's law u = gain x + shift, shape (k_s, n_s).
        shift: Shape (k_s,).
    """

    def law(state: Array, time: Array) -> Array:
        command = body_map.state(state) @ gain.T + shift
        return body_map.action(state, command)

    return law


def flipped(body_map: BodyMap, gain: Array, shift: Array) -> Law:
    """Return the law through the map with every sign of the state turned round."""

    def law(state: Array, time: Array) -> Array:
        command = body_map.state(-state) @ gain.T + shift
        return body_map.action(state, command)

    return law


def shuffled(
    body_map: BodyMap, gain: Array, shift: Array, size: int, rng: np.random.Generator
) -> tuple[Law, ...]:
    """Return laws through the map with the target's joints mixed up; none if it has but one.

    A joint takes its velocity with it. The command goes to the target as the map has it.

    Args:
        body_map: The map.
        gain: Of the source's law, shape (k_s, n_s).
        shift: Shape (k_s,).
        size: How many numbers the target's state has.
        rng: The chance of the orders.
    """
    half = size // 2
    laws = []
    for order in _orders(half, rng):
        which = np.concatenate([order, half + order])

        def law(state: Array, time: Array, which: Integers = which) -> Array:
            command = body_map.state(state[:, which]) @ gain.T + shift
            return body_map.action(state, command)

        laws.append(law)
    return tuple(laws)


def _orders(count: int, rng: np.random.Generator) -> list[Integers]:
    """Return some orders of so many joints, none of them the right one, no two the same."""
    if count <= MOST_WAYS:
        ways = [np.array(each) for each in permutations(range(count))][1:]
        chosen = rng.permutation(len(ways))[:SHUFFLES]
        return [ways[at] for at in sorted(chosen)]
    return [rng.permutation(count) for _ in range(SHUFFLES)]


def turned(body_map: AffineMap) -> AffineMap:
    """Return a map with every sign of the state turned round."""
    return replace(
        body_map,
        state_law=-body_map.state_law,
        lift_law=-body_map.lift_law,
        action_state=-body_map.action_state,
        read_state=-body_map.read_state,
    )


def mixed(body_map: AffineMap) -> AffineMap:
    """Return a map with the target's joints in the reverse order; a joint takes its speed along."""
    half = body_map.state_law.shape[1] // 2
    back = np.arange(half)[::-1]
    which = np.concatenate([back, half + back])
    return replace(
        body_map,
        state_law=body_map.state_law[:, which],
        lift_law=body_map.lift_law[which],
        lift_shift=body_map.lift_shift[which],
        action_state=body_map.action_state[:, which],
        read_state=body_map.read_state[:, which],
    )


SPOILT = (("flipped_anew", turned), ("shuffled_anew", mixed))
"""Maps that are wrong on purpose, to make a policy anew by."""


def control_scores(
    body: Body, body_map: BodyMap, gain: Array, shift: Array, *, rows: int, seed: int
) -> dict[str, float]:
    """Return the task's mean score through wrong maps: `flipped`, and `shuffled` if there is one.

    Args:
        body: The target.
        body_map: The map that is right.
        gain: Of the source's law, shape (k_s, n_s).
        shift: Shape (k_s,).
        rows: Runs of each.
        seed: Of the runs, and of the shuffles.
    """
    rng = np.random.default_rng([seed, 11])
    results = {"flipped": body.score(flipped(body_map, gain, shift), rows=rows, seed=seed)}
    laws = shuffled(body_map, gain, shift, body.size, rng)
    if laws:
        scores = [body.score(each, rows=rows, seed=seed) for each in laws]
        results["shuffled"] = float(np.mean(scores))
    return results
