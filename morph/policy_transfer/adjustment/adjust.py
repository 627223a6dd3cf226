"""From a policy, its source and runs of the target to the adjusted policy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.alignment.adjust import Adjustment, adjustment
from morph.alignment.inverse import GaussianInverse, Inverse, gaussian_inverse, local_inverse
from morph.alignment.regression import MOST_DATA
from morph.alignment.tracking_feasibility import TrackingFeasibility, following
from morph.errors import TransferError
from morph.policy.adjusted import Adjusted, newest
from morph.policy.angles import turning
from morph.policy.policy import Policy
from morph.policy_transfer.adjustment.beyond import beyond
from morph.policy_transfer.adjustment.source import SimulatedTask, states_of
from morph.search.target import Experience

STARTS = ("both", "source", "target")
"""Whose states the adjustment is learned at."""

INVERSES = ("gaussian", "local")
"""How inverse dynamics are learned: by a Gaussian process, or locally weighted regression."""


@dataclass(frozen=True, kw_only=True)
class AdjustSettings:
    """How a policy is adjusted."""

    starts: str = "both"
    """One of `STARTS`: states that the source visits, the target, or both."""
    inverse: str = "gaussian"
    """One of `INVERSES`."""
    guessed: bool = True
    """Whether inverse dynamics begin from the source's; without, from no command at all."""

    def __post_init__(self) -> None:
        """Check the names."""
        for name, known in (("starts", STARTS), ("inverse", INVERSES)):
            if getattr(self, name) not in known:
                raise TransferError(
                    f"{name} is {getattr(self, name)!r}",
                    where="the settings of an adjustment",
                    fix=f"use one of {', '.join(known)}",
                )


@dataclass(frozen=True, kw_only=True, eq=False)
class AdjustedPolicy:
    """An adjusted policy, and what it was made of."""

    policy: Adjusted
    """What to run on the target next."""
    adjustment: Adjustment
    """What it adds, for other policies of the same pair of bodies too."""
    inverse: Inverse
    """The target's inverse dynamics."""
    followed: TrackingFeasibility
    """Which steps of the source's run the target can follow: thesis eq. 11."""
    beyond: float
    """How much of what the target did no command of the source explains; 1 is what noise does."""


def adjusted(
    source: SimulatedTask,
    policy: Policy,
    runs: Sequence[Experience],
    *,
    rng: np.random.Generator,
    settings: AdjustSettings | None = None,
    inverse: Inverse | None = None,
) -> AdjustedPolicy:
    """Return a policy under which the target does what the source does under the given one.

    The target's inverse dynamics g are learned from its runs. At states x of the source, the
    target or both, under the source's command u, the source would go on to f(x, u), and
    g(x, f(x, u)) leads the target there. What is to be added to u is learned from these.

    Source: Gamboa Higuera 2015, section 3.3, steps 1 and 3 to 5.

    Args:
        source: Where the policy was made.
        policy: What to adjust; of one that was adjusted before, its source is adjusted anew.
        runs: What the target did, under this policy or any other.
        rng: The chance of the source's own run.
        settings: How; None for `AdjustSettings()`.
        inverse: Inverse dynamics of the target that are known already; None to learn them.

    Raises:
        TransferError: The runs are not of such a body, or the policy cannot be adjusted.
        SearchError: The policy's control period is not the task's.
        SamplesError: The runs show too little, or hold what is no number.
    """
    how = settings or AdjustSettings()
    policy = policy.source if isinstance(policy, Adjusted) else policy
    inverse = inverse or inverse_of(source, runs, how)
    own = source.run(policy, rng)
    visited = {"source": [own], "target": list(runs), "both": [own, *runs]}[how.starts]
    seen = [source.seen(policy, each) for each in visited]
    x = np.concatenate([states_of(each)[:-1] for each in visited])
    observed = np.concatenate([each[0] for each in seen])
    u = policy.act(observed, np.concatenate([each[1] for each in seen]))
    # A state that the source cannot bear asks for nothing.
    after = source.after(x, u)
    fine = np.flatnonzero(np.isfinite(after).all(axis=1))
    some = fine[:: max(1, -(-len(fine) // (MOST_DATA // 3)))]
    replicating, variance = inverse.predict(x[some], after[some])
    now = newest(policy.observation)
    angles = np.asarray(turning(source.task.robot, policy.observation)[now], dtype=bool)
    result = adjustment(observed[some][:, now], u[some], replicating, angles, variance)
    return AdjustedPolicy(
        policy=applied(result, policy),
        adjustment=result,
        inverse=inverse,
        followed=followed(source, own, runs, inverse),
        beyond=beyond(source, runs),
    )


def inverse_of(source: SimulatedTask, runs: Sequence[Experience], how: AdjustSettings) -> Inverse:
    """Return the inverse dynamics of the target, learned from its runs."""
    seen = source.transitions(runs)
    guess = source.inverse if how.guessed else None
    if how.inverse == "local":
        return local_inverse(seen, guess)
    result: GaussianInverse = gaussian_inverse(seen, guess)
    return result


def followed(
    source: SimulatedTask, own: Experience, runs: Sequence[Experience], inverse: Inverse
) -> TrackingFeasibility:
    """Return which steps of the source's run the target can follow: thesis eq. 11."""
    return following(
        source.transitions([own]),
        source.transitions(runs),
        inverse=inverse,
        low=source.plant.low,
        high=source.plant.high,
        noise=source.task.noise,
    )


def applied(result: Adjustment, policy: Policy) -> Adjusted:
    """Return another policy under an adjustment that was made for the same pair of bodies.

    Of a policy that is adjusted already, the source is adjusted anew.

    Raises:
        PolicyError: The policy cannot be adjusted, or sees other numbers.
    """
    policy = policy.source if isinstance(policy, Adjusted) else policy
    angles = np.zeros(policy.size)
    angles[newest(policy.observation)] = result.turns
    return Adjusted(
        source=policy,
        bias=result.bias,
        law=result.law,
        centre=result.centre,
        width=result.width,
        weight=result.weight,
        reach=result.reach,
        angles=angles,
        action=policy.action,
        period=policy.period,
        observation=policy.observation,
    )
