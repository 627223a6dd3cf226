"""Tests of interquartile means and their intervals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import trim_mean

from experiments.interval import interval, iqm


def test_the_interquartile_mean_is_the_trimmed_mean_where_quarters_are_whole() -> None:
    x = np.random.default_rng(3).normal(size=40)
    assert iqm(x) == pytest.approx(trim_mean(x, 0.25), rel=1e-12)


def test_numbers_at_the_edge_count_by_their_share() -> None:
    # Of 3 numbers the middle half is 1.5 numbers: the middle one and a quarter of both others.
    assert iqm(np.array([0.0, 6.0, 10.0])) == pytest.approx((0.25 * 0.0 + 6.0 + 0.25 * 10.0) / 1.5)


def test_a_quarter_of_infinite_times_leaves_it_finite() -> None:
    assert iqm(np.array([1.0, 2.0, 3.0, np.inf])) == pytest.approx(2.5)


def test_the_interval_of_a_mean_is_as_wide_as_its_standard_error_says() -> None:
    x = np.random.default_rng(5).normal(size=(1, 400))
    low, high = interval(x, of=lambda each: float(each.mean()))
    # 2 * 1.96 standard errors; quantiles of 2000 draws are off by some hundredths of it.
    assert high - low == pytest.approx(2 * 1.96 * x.std() / 20.0, rel=0.1)


def test_strata_of_unlike_height_do_not_widen_the_interval() -> None:
    x = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    assert interval(x) == (iqm(x), iqm(x))


def test_infinite_times_give_an_interval_without_a_warning() -> None:
    low, high = interval(np.array([[1.0, 2.0, np.inf, np.inf]]))
    assert low < np.inf
    assert high == np.inf
