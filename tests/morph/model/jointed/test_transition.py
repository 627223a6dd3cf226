"""Control periods: their middles, their noise, and which of them say anything."""

from __future__ import annotations

import numpy as np
import pytest

from morph.errors import SearchError
from morph.model.jointed.transition import JointTransitions, transitions

H = 0.1


def swinging(samples: int, noise: float = 0.0, speed: float = 1.0) -> JointTransitions:
    """Return periods of q = sin(speed t), seen through noise."""
    rng = np.random.default_rng(0)
    t = H * np.arange(samples)
    q, v = np.sin(speed * t)[:, None], speed * np.cos(speed * t)[:, None]
    blur = noise * rng.standard_normal((2, samples, 1))
    return transitions([(q + blur[0], v + blur[1], np.zeros((samples - 1, 1)))], H)


def test_the_middle_of_a_period_errs_by_no_more_than_its_formulas_say() -> None:
    position, velocity = swinging(60).middle
    t = H * (np.arange(59) + 0.5)
    # All derivatives of sin are at most 1. A margin of 1 % is for the terms of higher order.
    assert np.abs(position[:, 0] - np.sin(t)).max() <= 1.01 * H**4 / 384.0
    assert np.abs(velocity[:, 0] - np.cos(t)).max() <= 1.01 * H**2 / 8.0


def test_the_noise_of_positions_is_told_from_that_of_velocities() -> None:
    # The median of 4000 sizes has a standard error of about 1.2 / sqrt(4000) = 2 %, and neighbours
    # share a sample; of the variance the velocities' noise takes h^2 / 4 = 0.25 %.
    found = swinging(4001, noise=0.02).position_noise(np.array([0.02]))
    assert found == pytest.approx([0.02], rel=0.1)


def test_a_period_in_which_a_joint_turned_too_far_is_left_out() -> None:
    data = swinging(60, speed=8.0)
    turned = np.abs(data.next_position - data.position)[:, 0]
    left = data.slower((0,), 0.5)
    assert len(left.command) == int((turned <= 0.5).sum()) < 59
    assert len(data.slower((), 0.5).command) == 59
    with pytest.raises(SearchError, match="weaker random commands"):
        data.slower((0,), 1e-6)


def test_thinned_periods_are_spread_over_all() -> None:
    thin = swinging(60).thinned(10)
    assert len(thin.command) == 10
    assert thin.position[0] == swinging(60).position[0]
    assert thin.next_position[-1] == swinging(60).next_position[-1]


def test_too_few_periods_or_no_numbers_are_refused() -> None:
    with pytest.raises(SearchError, match="there are 5 control periods, and 8 are the fewest"):
        swinging(6)
    with pytest.raises(SearchError, match="no finite number"):
        transitions([(np.full((20, 1), np.nan), np.zeros((20, 1)), np.zeros((19, 1)))], H)
    with pytest.raises(SearchError, match="as many velocities as positions"):
        transitions([(np.zeros((20, 2)), np.zeros((20, 1)), np.zeros((19, 1)))], H)
