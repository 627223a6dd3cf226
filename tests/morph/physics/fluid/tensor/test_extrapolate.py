"""The limits of sequences that are known."""

from __future__ import annotations

import numpy as np
import pytest

from morph.physics.fluid.tensor.extrapolate import difference, extrapolated, limit_of_three


@pytest.mark.parametrize("order", [4 / 3, 2.0])
@pytest.mark.parametrize("ratio", [1.7, 2.0])
def test_a_pure_power_is_extrapolated_to_its_limit(order: float, ratio: float) -> None:
    coarse, fine = (np.array([3.0 + 0.4 * size**order]) for size in (ratio, 1.0))
    assert extrapolated(coarse, fine, ratio=ratio, order=order) == pytest.approx(3.0)


def test_three_levels_find_each_order_by_themselves() -> None:
    orders = np.array((1.3, 5 / 3, 2.0))
    levels = [3.0 - 0.4 * size**orders for size in (1.0, 0.5, 0.25)]
    assert limit_of_three(*levels) == pytest.approx(3.0)


def test_three_levels_that_jump_about_are_not_thrown_far() -> None:
    # At most (fine - middle) / (2^1.25 - 1) beyond the finest.
    found = limit_of_three(np.array([1.0, 1.0]), np.array([2.0, 1.0]), np.array([1.9, 1.0]))
    assert found == pytest.approx([1.9 - 0.1 / (2**1.25 - 1), 1.0])


def test_an_entry_that_hardly_counts_is_compared_with_a_tenth_of_the_displaced_fluid() -> None:
    one, other = np.diag((2.0, 1.0, 0.001)), np.diag((2.02, 1.0, 0.002))
    assert difference(one, other, np.ones(3)) == pytest.approx(0.01)
    assert difference(one, other, np.full(3, 0.1)) == pytest.approx(0.1)
