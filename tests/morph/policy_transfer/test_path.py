"""The path that is chosen goes over bodies that are near each other."""

from __future__ import annotations

import pytest

from morph.errors import TransferError
from morph.policy_transfer.balancers import balancer, seen_with
from morph.policy_transfer.body import Body
from morph.policy_transfer.path import apart, path


def quiet(name: str) -> Body:
    return seen_with(balancer(name), 0.0)


def test_a_hop_that_balances_is_no_farther_than_what_holding_still_scores() -> None:
    # One less the score of the oracle, 1, that is one less what holding still scores, about 0.1.
    source, easy = quiet("rider_rigid_driven"), quiet("rider_rigid_passive")
    assert apart(source, easy) == pytest.approx(0.1, abs=0.1)


def test_a_path_takes_what_is_near_and_leaves_out_what_is_not() -> None:
    bodies = (quiet("rider_rigid_driven"), quiet("rider_two_links_driven"), quiet("cartpole"))
    assert path(bodies, most=2)[0] is bodies[0]
    assert path(bodies, most=1) == (bodies[0], bodies[2])


def test_a_path_of_one_body_is_refused() -> None:
    with pytest.raises(TransferError, match=r"it has 1 bodies and 2 hops"):
        path((balancer("cartpole"),), most=2)
