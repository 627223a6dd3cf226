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
    # The ridge of 1e-9 takes that much of entries of about 1, over the least eigenvalue, 0.5.
    assert found * [1.0, 1e-4, 30.0, 1.0] == pytest.approx(exact * [1.0, 1e-4, 30.0, 1.0], abs=1e-8)


def test_equal_columns_count_once_and_share() -> None:
    rng = np.random.default_rng(0)
    one, other = rng.normal(size=(2, 50))
    columns, wide = np.column_stack([one, 2.0 * one, other]), np.full(3, np.inf)
    goal = 5.0 * one + other
    found, rank = bounded(columns.T @ columns, columns.T @ goal, -wide, wide)
    # Scaled columns are equal, so each explains half, but for rounding (1e-16 of products of about
    # 250) over the ridge (1e-9).
    assert (rank, found) == (2, pytest.approx([2.5, 1.25, 1.0], abs=1e-5))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("size", [6, 20])
def test_bounds_of_nearly_dependent_columns_are_found(size: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    # Of such columns exchanges of all wrong entries at once go round for ever.
    columns = rng.normal(size=(100, 2)) @ rng.normal(size=(2, size))
    columns += 0.03 * rng.normal(size=(100, size))
    goal, low, high = 30.0 * rng.normal(size=100), np.full(size, -0.5), np.full(size, 1.0)
    inner, along = columns.T @ columns, columns.T @ goal
    found, rank = bounded(inner, along, low, high)
    below, above = found <= low + 1e-9, found >= high - 1e-9
    assert rank == size
    assert below.any()
    assert above.any()
    # The conditions of Karush, Kuhn and Tucker, which hold at the minimum alone. Slopes are about
    # 1e3; the ridge of 1e-9 of a column's square, about 400, times an entry changes them.
    slope, slack = along - inner @ found, 1e-5
    assert np.all(slope[below] < slack)
    assert np.all(slope[above] > -slack)
    assert np.all(np.abs(slope[~(below | above)]) < slack)


def test_columns_that_rounding_leaves_indefinite_are_solved() -> None:
    # Two equal columns, whose difference has a square of -1e-7 where 0 would be.
    inner = np.array([[1.0, 1.0 + 1e-7], [1.0 + 1e-7, 1.0]])
    found, _ = bounded(inner, np.ones(2), np.full(2, -9.0), np.full(2, 9.0))
    assert found == pytest.approx([0.5, 0.5], abs=1e-6)


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
