"""Adjusting in rounds, directly, and through one policy for many trajectories."""

from __future__ import annotations

import numpy as np
import pytest

from morph.errors import TransferError
from morph.policy.policy import Policy
from morph.policy.radial import Radial
from morph.policy_transfer.adjustment.adjust import adjusted
from morph.policy_transfer.adjustment.direct import DirectAdjustment
from morph.policy_transfer.adjustment.multi_trajectory import Many
from morph.policy_transfer.adjustment.rounds import best, rounds
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.search.evaluate import evaluate
from morph.search.target import Experience, Simulated


def test_rounds_end_with_the_first_success(
    source: SimulatedTask, plan: Policy, rough: Simulated
) -> None:
    found = rounds(source, [plan], rough, trials=3, rng=np.random.default_rng(0))
    assert not found[0].shown.success
    assert found[-1].shown.success
    assert len(found) == 2
    assert best(found) is found[-1]


def test_more_rounds_are_made_of_all_runs_so_far(
    source: SimulatedTask, plan: Policy, rough: Simulated
) -> None:
    found = rounds(source, [plan], rough, trials=2, rng=np.random.default_rng(0), until=False)
    assert len(found) == 3
    assert found[2].shown.success


def test_without_a_policy_there_are_no_rounds(source: SimulatedTask, rough: Simulated) -> None:
    with pytest.raises(TransferError, match="there are 0 policies for 1 trials"):
        rounds(source, [], rough, trials=1, rng=np.random.default_rng(0))


def test_directly_changed_it_needs_more_trials_and_succeeds(
    source: SimulatedTask, plan: Policy, rough: Simulated
) -> None:
    found = DirectAdjustment().tune(source.task, plan, rough, trials=25, seed=100)
    assert len(found.experience) == 25
    losses = [line.loss for line in found.trials]
    assert losses == sorted(losses, reverse=True)
    assert losses[-1] < 0.6 * losses[0]
    again = DirectAdjustment().tune(source.task, plan, rough, trials=3, seed=100)
    assert [line.loss for line in again.trials] == losses[:3]


def test_one_policy_without_a_clock_is_made_of_many_trajectories(
    source: SimulatedTask, plan: Policy, rough: Simulated, run: Experience
) -> None:
    made = adjusted(source, plan, [run], rng=np.random.default_rng(1))
    policy, promised = Many(rows=25, rounds=3).trained(
        source, made.adjustment, [plan], rng=np.random.default_rng(5)
    )
    assert isinstance(policy, Radial)
    score = evaluate(rough.task, policy, rough.simulator, rng=np.random.default_rng(3), rows=20)
    # The plan itself, unadjusted, never succeeds there; no clock and no past is the harder case.
    assert promised.share > 0.4
    assert score.share > 0.3
