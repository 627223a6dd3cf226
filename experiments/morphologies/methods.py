"""Every way to balance a body from few transitions, with and without a source."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from align.maps.affine_map import AffineMap
from align.samples import Transitions
from morph.arrays import Array
from morph.transfer.body import Body
from morph.transfer.hop import hop
from morph.transfer.mapped.belief import learned, read
from morph.transfer.mapped.feedback import cautious, plain
from morph.transfer.mapped.lift import lift

RIDGE = 1e-3
"""What a square of a weight costs against squares of readings, of the ridge."""

MAPPED = ("hop", "map_only", "shuffled", "flipped", "shuffled_map_only", "flipped_map_only")
"""What uses the source, rightly or wrongly."""

SOURCELESS = ("least_squares", "ridge", "structured", "structured_cautious")
"""What fits the target alone."""


def mapped(
    source: Body, target: Body, seen: Transitions, *, seed: int, controls: bool
) -> dict[str, Array]:
    """Return the feedback of every way that uses the source, rightly or wrongly, by its name.

    Wrong maps, as controls: one learned from commands in another order, and one with every
    command turned round.
    """
    right = lift(source, target, seen)
    rng = np.random.default_rng([seed, 11])
    mixed = replace(seen, command=seen.command[rng.permutation(len(seen.command))])
    shuffled = lift(source, target, mixed)
    told = {"": right}
    if controls:
        told |= {"shuffled": shuffled, "flipped": flipped(right)}
    found: dict[str, Array] = {}
    for name, each in told.items():
        found[name or "hop"] = hop(source, target, seen, seed=seed, seen_as=each).gain
        found[f"{name}_map_only".lstrip("_")] = through(source, target, each)
    return found


def flipped(right: AffineMap) -> AffineMap:
    """Return a map with every command turned round."""
    return replace(
        right,
        action_law=-right.action_law,
        action_state=-right.action_state,
        read_law=-right.read_law,
        read_state=-right.read_state,
    )


def through(source: Body, target: Body, seen_as: AffineMap) -> Array:
    """Return the source's feedback seen through a map, shape (nu, n)."""
    gain = plain(read(source), source)
    return np.asarray(seen_as.action_law @ gain @ seen_as.state_law + seen_as.action_state)


def sourceless(target: Body, seen: Transitions) -> dict[str, Array]:
    """Return the feedback of every way without a source, by its name."""
    believed = learned(seen, None, target)
    return {
        "least_squares": plain(_squares(seen, 0.0), target),
        "ridge": plain(_squares(seen, RIDGE), target),
        "structured": plain(believed.step, target),
        "structured_cautious": cautious(believed, target),
    }


def _squares(seen: Transitions, ridge: float) -> Array:
    """Return (A, B) by least squares, pulled towards a body that stays where it is."""
    x = np.hstack([seen.state, seen.command])
    n = seen.state.shape[1]
    pull = np.sqrt(ridge) * np.eye(x.shape[1])
    rows = np.concatenate([x, pull])
    change = np.concatenate([seen.after - seen.state, np.zeros((x.shape[1], n))])
    found = np.linalg.lstsq(rows, change, rcond=None)[0].T
    found[:, :n] += np.eye(n)
    return np.asarray(found)
