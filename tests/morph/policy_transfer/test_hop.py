"""Tests of a hop."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.morphologies.methods import flipped
from morph.errors import TransferError
from morph.policy_transfer.balancers import balancer, explored
from morph.policy_transfer.hop import hop
from morph.policy_transfer.mapped.lift import lift


def test_a_hop_to_a_rider_balances_it_and_a_flipped_map_alone_does_not() -> None:
    source, target = balancer("cartpole"), balancer("rider_rigid_passive")
    seen = explored(target, 60, np.random.default_rng(150))
    hopped = hop(source, target, seen, seed=150, rows=2)
    assert hopped.samples == 60
    assert hopped.scores["map_only"] > 0.95
    assert hopped.quality["round_trip"] == pytest.approx(1.0)
    wrong = hop(source, target, seen, seed=150, rows=2, seen_as=flipped(lift(source, target, seen)))
    assert wrong.scores["map_only"] < 0.3


def test_a_hop_from_a_body_to_itself_finds_the_map_that_changes_nothing() -> None:
    source = balancer("cartpole")
    seen = explored(source, 240, np.random.default_rng(150))
    seen_as = lift(source, source, seen)
    assert seen_as.state_law == pytest.approx(np.eye(4), abs=1e-6)
    # A command moves the speeds by 1 a period and readings have noise 0.014: 240 of them leave
    # 0.014 / sqrt(240) = 0.1 %, and what else acts is fitted beside it.
    assert seen_as.read_law[0, 0] == pytest.approx(1.0, abs=0.02)


def test_transitions_of_another_body_are_refused() -> None:
    source, target = balancer("cartpole"), balancer("cart_two_links")
    seen = explored(source, 12, np.random.default_rng(150))
    with pytest.raises(TransferError, match=r"has 4 numbers and of the target 6"):
        hop(source, target, seen, seed=150)
