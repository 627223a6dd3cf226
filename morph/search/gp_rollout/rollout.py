"""Expected loss of a policy over a rollout of state distributions, with its gradient."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.search.gp_rollout.belief import ControlLaw, GPPlant
from morph.search.moments.saturating import ExpectedCost, expected


@dataclass(frozen=True, kw_only=True, eq=False)
class Imagined:
    """What is expected of a policy."""

    loss: Array
    """The expected loss, shape (...,)."""
    gradient: Array
    """Its derivative in the policy's numbers, shape (..., numbers)."""
    mean: Array
    """Mean of the state at each control time, shape (samples, ..., d)."""
    covariance: Array
    """Its covariance, shape (samples, ..., d, d)."""


def imagine(
    plant: GPPlant,
    law: ControlLaw,
    costs: tuple[ExpectedCost, ...],
    m: Array,
    S: Array,
    periods: int,
) -> Imagined:
    """Return the expected loss of a policy over some control periods, with its gradient.

    Each state is taken to be Gaussian, and each step's moments are exact. This is the whole of
    PILCO's policy evaluation and of its gradient, by one pass forward and one back. What it costs
    to take states for Gaussian: on the cart-pole's swing-up, against 4000 particles on the same
    process, deviations are right to 8 % for 30 periods; where some runs are then caught at the
    top and others fall, no Gaussian says so, deviations become several times too great, and
    the expected loss is 43.0 in place of 36.9.

    Source: Deisenroth and Rasmussen 2011, PILCO, ICML, eqs. 2, 10 and 26 to 30.

    Args:
        plant: What is believed of the body.
        law: The policy.
        costs: Terms of the cost, of (x, sin a, cos a).
        m: Mean of the first state, shape (..., d).
        S: Its covariance, shape (..., d, d).
        periods: How many control periods; the cost is summed over one more sample.
    """
    means, spreads, tapes = [m], [S], []
    for _ in range(periods):
        m, S, tape = plant.forward(m, S, law)
        means.append(m)
        spreads.append(S)
        tapes.append(tape)
    z_last, C_last, last = plant.lift.forward(m, S)
    z = np.stack([*(each.z for each in tapes), z_last])
    C = np.stack([*(each.C for each in tapes), C_last])
    loss, into_z, into_C = expected(costs, z, C)
    into_m, into_S = plant.lift.backward(last, into_z[-1], into_C[-1])
    gradient: Array = np.zeros(())
    for at in range(periods - 1, -1, -1):
        into_m, into_S, numbers = plant.backward(
            tapes[at], law, into_m, into_S, into_z[at], into_C[at]
        )
        gradient = gradient + numbers
    return Imagined(
        loss=loss.sum(axis=0),
        gradient=gradient,
        mean=np.stack(means),
        covariance=np.stack(spreads),
    )
