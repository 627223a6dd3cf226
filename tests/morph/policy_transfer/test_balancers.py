"""Tests of the bodies that balance."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import RobotError, TransferError
from morph.policy_transfer.balancers import balancer, explored, without
from morph.policy_transfer.body import linear_law, still_law
from morph.policy_transfer.mapped.feedback import plain


@pytest.mark.parametrize("name", ["cart_three_links_servo", "rider_two_links_passive"])
def test_holding_still_fails_and_the_oracle_balances(name: str) -> None:
    target = balancer(name)
    gain = plain(np.hstack(target.linear), target)
    assert target.score(still_law(len(gain)), rows=4, seed=150) <= 0.3
    assert target.score(linear_law(gain), rows=4, seed=150) >= 0.95


def test_a_joint_whose_servo_is_taken_away_swings_like_a_pendulum_that_stands() -> None:
    robot = load("cart_two_links_servo")
    free = without(robot, "hinge_1")
    assert [each.name for each in free.actuators] == ["slide", "hinge_2"]
    # Both poles held straight are one rod of 1 m: it falls with sqrt(3 g / 2 l) = 3.8 per s, and
    # a cart held in place by its servo leaves it that; 20 ms give exp(3.8 * 0.02) = 1.08.
    A = balancer("cart_two_links_servo").linear[0]
    assert np.abs(np.linalg.eigvals(A)).max() == pytest.approx(1.08, abs=0.02)


def test_an_unknown_body_or_actuator_is_refused_by_name() -> None:
    with pytest.raises(TransferError, match=r"no push is fixed for pendulum"):
        balancer("pendulum")
    with pytest.raises(RobotError, match=r"elbow"):
        without(load("cartpole"), "elbow")


def test_exploring_stays_near_rest_and_repeats_by_its_seed() -> None:
    target = balancer("rider_three_links_driven")
    seen = explored(target, 30, np.random.default_rng(150))
    again = explored(target, 30, np.random.default_rng(150))
    assert (seen.after == again.after).all()
    # Of noise 0.01 a state begins at 3 rad/s at most, and 5 deviations of the noise add 0.05.
    assert np.abs(seen.state).max() <= 3.05
