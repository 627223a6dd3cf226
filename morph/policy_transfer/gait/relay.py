"""A chain of gaits: one body's pattern carried to the next, hop after hop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.errors import TransferError
from morph.policy_transfer.gait.hop import Budget, GaitBody, begun, hop
from morph.policy_transfer.gait.mover import Mover


@dataclass(frozen=True, kw_only=True, eq=False)
class Chained:
    """What a chain came to."""

    bodies: tuple[GaitBody, ...]
    """Every body with its gait, the source first."""

    @property
    def samples_total(self) -> int:
        """Control periods on all targets together; the source's own are not among them."""
        return sum(each.samples for each in self.bodies[1:])


def relay(
    chain: Sequence[Mover], *, seed: int, learning: int = 200, budget: Budget | None = None
) -> Chained:
    """Return a gait carried along a chain of bodies.

    Args:
        chain: The bodies; the first learns by itself.
        seed: Chance begins from it.
        learning: Trials of the first.
        budget: What each hop may cost.

    Raises:
        TransferError: There is no target, or a hop cannot be made.
    """
    if len(chain) < 2:
        raise TransferError(
            f"a chain of {len(chain)} bodies has no target",
            where="a relay of gaits",
            fix="give two bodies or more",
        )
    rng = np.random.default_rng([seed, 0])
    bodies = [begun(chain[0], rng=rng, trials=learning, budget=budget)]
    for number, target in enumerate(chain[1:], start=1):
        rng = np.random.default_rng([seed, number])
        bodies.append(hop(bodies[-1], target, rng=rng, budget=budget))
    return Chained(bodies=tuple(bodies))
