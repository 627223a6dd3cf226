"""The map of a hop: configurations by what the task looks at, commands by consistency."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import BodyMap
from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.policy_transfer.body import Body
from morph.policy_transfer.mapped.belief import read


def lift(source: Body, target: Body, seen: Transitions) -> AffineMap:
    """Return the map whose source does, at mapped states and commands, what the target did.

    Configurations: q_s = J q with C_s J = C_t, so that the task sees the same in both. Speeds
    follow by the same J. Commands: u_s = R a + F y by least squares of the source's dynamics.
    """
    state = np.linalg.pinv(_aligned(source, target)[0]) @ _aligned(source, target)[1]
    n, k = target.size, seen.command.shape[1]
    law, source_told = np.hsplit(read(source), [source.size])
    wanted = seen.after @ state.T - seen.state @ state.T @ law.T
    unit = np.concatenate([np.ones(n), np.sqrt(np.square(seen.command).mean(axis=0)) + 1e-12])
    x = np.hstack([seen.state, seen.command]) / unit
    source_u = wanted @ np.linalg.pinv(source_told).T
    weak = np.eye(n + k) * (1e-4 * len(x))
    command = np.linalg.solve(x.T @ x + weak, x.T @ source_u).T / unit
    read_state, read_law = command[:, :n], command[:, n:]
    span = _span(target)
    back = span[:, None] * np.linalg.pinv(read_law * span, rcond=1e-8)
    return AffineMap(
        state_law=state,
        state_shift=np.zeros(len(state)),
        lift_law=np.asarray(np.linalg.pinv(state), dtype=float),
        lift_shift=np.zeros(n),
        action_law=back,
        action_state=-back @ read_state,
        action_shift=np.zeros(k),
        read_law=read_law,
        read_state=read_state,
        read_shift=np.zeros(len(read_law)),
    )


def _aligned(source: Body, target: Body) -> tuple[Array, Array]:
    """Return the outcomes of both, of the numbers that both have."""
    first, second = source.outcome, target.outcome
    rows, more = len(first) // 2, len(second) // 2
    both = min(rows, more)
    pick_s = [*range(both), *range(rows, rows + both)]
    pick_t = [*range(both), *range(more, more + both)]
    return first[pick_s], second[pick_t]


def _span(target: Body) -> Array:
    low, high = target.bounds
    return np.asarray(0.5 * np.minimum(high - low, 2.0 * np.pi))


def quality_of(seen_as: BodyMap, source: Body, seen: Transitions) -> Mapping[str, float]:
    """Return how well a map goes there and back, and agrees with the source; 1 at best."""
    x = seen_as.state(seen.state)
    again = seen_as.state(seen_as.state_back(x))
    law, command = np.hsplit(read(source), [source.size])
    after = x @ law.T + seen_as.action_back(seen.state, seen.command) @ command.T
    true = seen_as.state(seen.after)
    change = np.square(true - x).sum()
    return {
        "round_trip": float(1.0 - np.square(again - x).sum() / max(np.square(x).sum(), 1e-12)),
        "dynamics": float(1.0 - np.square(true - after).sum() / max(change, 1e-12)),
    }
