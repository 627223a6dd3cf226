"""A quadratic in a box is least where no other point of the box is lower."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from morph.arrays import Array
from morph.search.trajectory.boxed import boxed, freed_gain


def problems(rows: int, size: int) -> tuple[Array, Array, Array, Array]:
    rng = np.random.default_rng(3)
    root = rng.normal(size=(rows, size, size))
    H = root @ root.swapaxes(1, 2) + 0.1 * np.eye(size)
    low = -rng.uniform(0.0, 1.0, (rows, size))
    return H, 3.0 * rng.normal(size=(rows, size)), low, low + rng.uniform(0.1, 2.0, (rows, size))


def by_every_face(H: Array, g: Array, low: Array, high: Array) -> float:
    """Return the least value, found by solving on each of the 3^n faces of the box."""
    least = np.inf
    for face in product((-1, 0, 1), repeat=len(g)):
        side = np.array(face)
        x = np.where(side < 0, low, high).astype(float)
        free = side == 0
        if free.any():
            rest = g[free] + H[np.ix_(free, ~free)] @ x[~free]
            x[free] = -np.linalg.solve(H[np.ix_(free, free)], rest)
        if (x >= low - 1e-12).all() and (x <= high + 1e-12).all():
            least = min(least, float(0.5 * x @ H @ x + g @ x))
    return least


@pytest.mark.parametrize("size", [1, 2, 4])
def test_no_face_of_the_box_holds_a_lower_point(size: int) -> None:
    H, g, low, high = problems(60, size)
    x, free = boxed(H, g, low, high)
    assert (x >= low).all()
    assert (x <= high).all()
    for row in range(len(g)):
        value = 0.5 * x[row] @ H[row] @ x[row] + g[row] @ x[row]
        # Both are exact but for rounding: values of order 10, of which 1e-9 is far more.
        assert value == pytest.approx(by_every_face(H[row], g[row], low[row], high[row]), abs=1e-9)
    slope = g + (H @ x[..., None])[..., 0]
    assert np.abs(slope[free]).max() < 1e-7


def test_in_a_box_without_sides_the_gain_is_that_of_the_whole_matrix() -> None:
    H, g, _, _ = problems(5, 3)
    wide = np.full(g.shape, np.inf)
    x, free = boxed(H, g, -wide, wide)
    assert free.all()
    assert x == pytest.approx(-np.linalg.solve(H, g[..., None])[..., 0])
    G = np.ones((5, 3, 2))
    assert freed_gain(H, G, free) == pytest.approx(-np.linalg.solve(H, G))


def test_a_number_that_a_side_holds_has_no_gain() -> None:
    H, G = np.array([[[2.0, 1.0], [1.0, 3.0]]]), np.array([[[4.0], [6.0]]])
    gain = freed_gain(H, G, np.array([[False, True]]))
    # The second alone: -6 / 3.
    assert gain[0, :, 0] == pytest.approx([0.0, -2.0])
