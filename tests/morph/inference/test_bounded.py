"""Least squares within bounds against SciPy on the columns themselves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from morph.inference.bounded import bounded


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("width", [0.2, 0.5, np.inf])
def test_it_agrees_with_the_columns_themselves(seed: int, width: float) -> None:
    rng = np.random.default_rng(seed)
    # Columns of masses and of gains differ by orders of magnitude.
    columns = rng.normal(size=(50, 4)) * [1.0, 1e-4, 30.0, 1.0]
    goal = columns @ (rng.normal(size=4) / [1.0, 1e-4, 30.0, 1.0]) + rng.normal(size=50)
    low, high = -width / np.array([1.0, 1e-4, 30.0, 1.0]), 2.0 * width / np.ones(4)
    exact = lsq_linear(columns, goal, bounds=(low, high), method="bvls", tol=1e-14).x
    found, rank = bounded(columns.T @ columns, columns.T @ goal, low, high)
    assert rank == 4
    # A Gram matrix squares the condition, about 1e1 here once columns are scaled.
    assert found * [1.0, 1e-4, 30.0, 1.0] == pytest.approx(exact * [1.0, 1e-4, 30.0, 1.0], abs=1e-9)


def test_equal_columns_count_once_and_share() -> None:
    rng = np.random.default_rng(0)
    one, other = rng.normal(size=(2, 50))
    columns, wide = np.column_stack([one, 2.0 * one, other]), np.full(3, np.inf)
    goal = 5.0 * one + other
    found, rank = bounded(columns.T @ columns, columns.T @ goal, -wide, wide)
    # Scaled columns are equal, so each explains half.
    assert (rank, found) == (2, pytest.approx([2.5, 1.25, 1.0], abs=1e-7))


def test_a_zero_column_stays_at_the_bound_nearest_to_zero() -> None:
    inner = np.diag([1.0, 0.0])
    found, rank = bounded(inner, np.array([0.5, 0.0]), np.array([-1.0, 0.2]), np.ones(2))
    assert (rank, found.tolist()) == (1, [0.5, 0.2])


def test_what_shows_nowhere_between_its_bounds_stays_at_zero() -> None:
    # The second column moves readings by 0.01 standard deviations for one, 0.024 at most.
    inner, along = np.diag([1.0, 1e-4]), np.array([0.5, 0.01])
    for width, rank, best in ((1.2, 1, 0.0), (120.0, 2, 100.0)):
        found, counted = bounded(inner, along, np.full(2, -width), np.full(2, width))
        assert (counted, found) == (rank, pytest.approx([0.5, best]))


def test_an_unbounded_column_however_large_counts() -> None:
    found, rank = bounded(
        np.diag([1e60]), np.array([1e60]), np.full(1, -np.inf), np.full(1, np.inf)
    )
    assert (rank, found) == (1, pytest.approx([1.0]))
