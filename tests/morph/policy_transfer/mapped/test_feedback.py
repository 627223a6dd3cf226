"""Tests of what is believed of a body, and of the feedback that is made from it."""

from __future__ import annotations

import numpy as np
import pytest

from morph.policy_transfer.balancers import balancer, explored
from morph.policy_transfer.mapped.belief import LinearPosterior, learned, stepped
from morph.policy_transfer.mapped.feedback import cautious, plain


def test_without_doubt_cautious_feedback_is_the_feedback_of_the_riccati_equation() -> None:
    target = balancer("cartpole")
    law = np.array([[0.0, -7.0, -0.3, 0.0, 1.5], [0.0, 30.0, 0.5, 0.0, -2.5]])
    believed = LinearPosterior(law=law, cover=np.zeros((10, 10)), period=0.02)
    # Value iteration stops when its cost changes by less than a thousandth.
    assert cautious(believed, target) == pytest.approx(plain(believed.step, target), rel=0.1)


def test_doubt_about_what_commands_do_makes_feedback_smaller() -> None:
    target = balancer("cartpole")
    law = np.array([[0.0, -7.0, -0.3, 0.0, 1.5], [0.0, 30.0, 0.5, 0.0, -2.5]])
    cover = np.zeros((10, 10))
    cover[4, 4] = cover[9, 9] = 0.3**2
    sure = LinearPosterior(law=law, cover=np.zeros((10, 10)), period=0.02)
    unsure = LinearPosterior(law=law, cover=cover, period=0.02)
    assert np.abs(cautious(unsure, target)).sum() < np.abs(cautious(sure, target)).sum()


def test_places_follow_from_speeds_by_the_mean_over_a_period() -> None:
    # One joint, acceleration 3 q + 2 u: v' = v + 0.06 q + 0.04 u, q' = q + 0.01 (v + v').
    step = stepped(np.array([[3.0, 0.0, 2.0]]), 0.02)
    expected = [[1.0 + 0.0006, 0.02, 0.0004], [0.06, 1.0, 0.04]]
    assert step == pytest.approx(np.array(expected))


def test_the_true_response_to_a_command_is_within_its_standard_deviations() -> None:
    target = balancer("cartpole")
    believed = learned(explored(target, 120, np.random.default_rng(151)), None, target)
    true = target.linear[1][2:, 0] / 0.02
    sigma = np.sqrt(np.diag(believed.cover)).reshape(2, 5)[:, 4]
    assert (np.abs(believed.law[:, 4] - true) < 5.0 * sigma).all()
