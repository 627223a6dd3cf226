"""Scales."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.errors import SamplesError
from morph.alignment.scale import scale


def test_scaled_numbers_have_no_mean_and_unit_spread_and_come_back() -> None:
    x = np.random.default_rng(0).normal([3.0, -1.0], [0.1, 20.0], size=(50, 2))
    made = scale(x)
    np.testing.assert_allclose(made(x).mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(made(x).std(axis=0), 1.0, atol=1e-12)
    np.testing.assert_allclose(made.back(made(x)), x, atol=1e-12)


def test_a_number_that_never_changes_is_only_moved() -> None:
    made = scale(np.array([[1.0, 5.0], [2.0, 5.0]]))
    assert made.spread[1] == 1.0
    np.testing.assert_array_equal(made(np.array([2.0, 6.0])), [1.0, 1.0])


def test_one_row_has_no_spread_and_is_refused() -> None:
    with pytest.raises(SamplesError, match=r"shape \(1, 2\)"):
        scale(np.zeros((1, 2)))
