"""Actions that are stored beside a policy's numbers, to find out whether it still gives them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from morph.arrays import Array
from morph.errors import PolicyError
from morph.policy.policy import Policy

REPLAYED = 64
"""How many actions are stored, to be replayed when the policy is read."""

MOST_REPLAYED = 1000
"""Most that are replayed."""

TOLERANCE = 1e-6
"""How near a replayed action must come to the stored one, in its unit or, above 1, relative."""

AT_ONCE = 100
"""Actions replayed at once, so that a stranger's numbers cannot ask for all the memory."""


def to_replay(
    policy: Policy, *, seconds: float, observed: Array | None, times: Array | None
) -> dict[str, Array]:
    """Return observations, times and actions, `REPLAYED` of them, as they are stored.

    Args:
        policy: What acts.
        seconds: Up to when times are drawn.
        observed: What was really seen, shape (samples, observations); None to draw it.
        times: When, s, shape (samples,); needed with `observed`.

    Raises:
        PolicyError: What was seen does not fit the policy.
    """
    if observed is None:
        # Fixed seed: the same policy is written as the same bytes.
        rng = np.random.default_rng(0)
        time = np.sort(rng.uniform(0.0, seconds, REPLAYED))
        seen = policy.typical(time, rng)
    else:
        seen, time = _chosen(policy, np.asarray(observed, dtype=float), times)
    action = policy.act(seen, time)
    return {"replay.time": time, "replay.observation": seen, "replay.action": action}


def _chosen(policy: Policy, observed: Array, times: Array | None) -> tuple[Array, Array]:
    """Return some of what was seen, from its beginning to its end."""
    time = np.asarray([] if times is None else times, dtype=float)
    fits = observed.shape == (len(time), policy.size) and len(time)
    if not (fits and np.isfinite(observed).all() and np.isfinite(time).all()):
        raise PolicyError(
            f"what was observed has the shape {observed.shape}, at {time.size} times",
            where=f"a policy of kind {policy.kind}",
            fix=f"give finite numbers of shape (samples, {policy.size}), and as many times",
        )
    some = np.unique(np.linspace(0, len(time) - 1, REPLAYED).round().astype(np.int64))
    return observed[some], time[some]


def check_replay(policy: Policy, tensors: Mapping[str, Array], *, where: str) -> None:
    """Check a policy against the actions that were stored with it.

    Raises:
        PolicyError: They are missing, too many, or others than it gives.
    """
    time, seen, stored = (
        tensors.get(f"replay.{name}", np.empty(0)) for name in ("time", "observation", "action")
    )
    rows = len(time) if time.ndim == 1 else 0
    shapes = (seen.shape, stored.shape)
    if not 0 < rows <= MOST_REPLAYED or shapes != (
        (rows, policy.size),
        (rows, len(policy.action)),
    ):
        raise PolicyError(
            "it lacks observations and actions to replay, or holds too many",
            where=where,
            fix="write it again",
        )
    parts = [slice(first, first + AT_ONCE) for first in range(0, rows, AT_ONCE)]
    again = np.concatenate([policy.act(seen[part], time[part]) for part in parts])
    worst = apart(again, stored)
    if not worst <= TOLERANCE:
        raise PolicyError(
            f"replayed, its actions differ from the stored ones by {worst:.2g}",
            where=where,
            fix="write it again; its numbers have changed since",
        )


def apart(again: Array, stored: Array) -> float:
    """Return how far actions are from the stored ones, in their unit or, above 1, relative."""
    return float(np.max(np.abs(again - stored) / np.maximum(1.0, np.abs(stored)), initial=0.0))
