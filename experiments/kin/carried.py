"""Policies carried from one body to another: well, by an old description, wrongly, by chance."""

from __future__ import annotations

import numpy as np

from experiments.kin.bodies import Kin, Source, regulator
from morph.arrays import Array
from morph.errors import SearchError
from morph.policy_transfer.body import Body


def by_features(source: Source, target: Kin, law: Array) -> Array | None:
    """Return the target's gain that makes lean and place move as the source's would.

    The lean and place of the target are seen as the source's, x = pinv(C_s) C_t y. The commands
    are those that come nearest, in bounds, to the rates that the source's lean and place would
    have one period later; what they leave free holds the target's posture.

    Args:
        source: Whose policy is carried.
        target: Whose outcome and bounds are told; its true model is not looked at.
        law: F of x' = F (x; u) that the target is thought to obey, shape (n, n + k).
    """
    n = target.body.size
    A, B = law[:, :n], law[:, n:]
    low, high = target.body.bounds
    half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    theirs, wanted = wanted_of(source, target.body)
    try:
        posture = regulator(A, B, target.body.outcome, (low, high), 1.0)
    except (SearchError, np.linalg.LinAlgError, ValueError):
        return None
    rates = slice(len(theirs) // 2, None)
    reach = (theirs @ B)[rates] * half
    inverse = half[:, None] * np.linalg.pinv(reach, rcond=0.05)
    free = np.eye(len(half)) - inverse @ (theirs @ B)[rates]
    gain = inverse @ (wanted[rates] - (theirs @ A)[rates]) + free @ posture
    return gain if np.isfinite(gain).all() else None


def wanted_of(source: Source, target: Body) -> tuple[Array, Array]:
    """Return what both tasks look at of the target, and what the source would make of it.

    Returns:
        C_t, shape (z, n), and W with W y what C_t y should be one period after the state y.
    """
    ours, theirs = _common(source.body.outcome, target.outcome)
    A, B = source.body.linear
    return theirs, ours @ (A + B @ source.gain) @ np.linalg.pinv(ours) @ theirs


def agreement(reads: Array, wanted: Array, law: Array, gain: Array, state: Array) -> float:
    """Return how nearly a target under a carried policy does as the source would, 1 at best.

    One minus the square of what differs over the square of what was to change, one period after
    the states that were seen.

    Args:
        reads: C_t, as `wanted_of` gives it.
        wanted: W, likewise.
        law: F that the target is thought to obey.
        gain: The carried policy, u = K x.
        state: The states that were seen, shape (m, n).
    """
    after = state @ law[:, : state.shape[1]].T + state @ gain.T @ law[:, state.shape[1] :].T
    asked = state @ (wanted - reads).T
    off = after @ reads.T - state @ wanted.T
    return 1.0 - float(np.square(off).sum() / max(np.square(asked).sum(), 1e-12))


def _common(ours: Array, theirs: Array) -> tuple[Array, Array]:
    """Return the rows of both outcomes that both have: the lean, and the place if both."""
    least = min(len(ours), len(theirs)) // 2
    first, second = (
        each[[*range(least), *range(len(each) // 2, len(each) // 2 + least)]]
        for each in (ours, theirs)
    )
    return first, second


def flipped(gain: Array, rng: np.random.Generator) -> Array:
    """Return a gain one command of which, or one joint of which, has the wrong sign."""
    wrong = gain.copy()
    nv = gain.shape[1] // 2
    at = int(rng.integers(nv + len(gain)))
    if at < len(gain):
        wrong[at] *= -1.0
    else:
        wrong[:, [at - len(gain), at - len(gain) + nv]] *= -1.0
    return wrong


def shuffled(gain: Array, rng: np.random.Generator) -> Array:
    """Return a gain whose joints, and commands, are taken for one another."""
    nv = gain.shape[1] // 2
    order = rng.permutation(nv)
    while (order == np.arange(nv)).all():
        order = rng.permutation(nv)
    rows = rng.permutation(len(gain))
    return np.asarray(gain[rows][:, np.concatenate([order, order + nv])])


def scaled(gain: Array, rng: np.random.Generator) -> Array:
    """Return a gain of another strength: units, or gears, that a map has wrong."""
    factor = float(np.exp(rng.uniform(np.log(0.1), np.log(8.0))))
    return factor * gain
