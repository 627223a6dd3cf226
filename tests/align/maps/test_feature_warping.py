"""Curves and networks that straighten numbers: their slopes, and their inverses."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.errors import MapError
from morph.alignment.maps.feature_warping import (
    Curves,
    InvertibleWarp,
    NetworkWarp,
    flat_curves,
    idle_network,
    straight_of,
)


def members() -> list[InvertibleWarp]:
    rng = np.random.default_rng(100)
    still: list[InvertibleWarp] = [flat_curves(3, 5, 2.5), idle_network(3, 6, rng)]
    # Small enough that nothing is mended: slopes are those of what needs no mending.
    return [
        each.at(each.parameters + 0.05 * rng.standard_normal(each.parameters.size))
        for each in still
    ]


@pytest.mark.parametrize("each", members(), ids=lambda each: type(each).__name__)
def test_slopes_are_those_of_finite_differences(each: InvertibleWarp) -> None:
    t = np.random.default_rng(101).standard_normal((7, 3))
    near = 1e-6 * np.eye(3)
    by_t = np.stack([(each.value(t + d) - each.value(t - d)) / 2e-6 for d in near], axis=2)
    # Central differences err by the third derivative times 1e-12 / 6, and 1e-16 / 1e-6 of rounding.
    np.testing.assert_allclose(each.steep(t), by_t, atol=1e-8)
    own = each.parameters
    rows = 1e-6 * np.eye(own.size)
    by_own = [(each.at(own + d).value(t) - each.at(own - d).value(t)) / 2e-6 for d in rows]
    np.testing.assert_allclose(each.slope(t), np.stack(by_own, axis=2), atol=1e-7)


@pytest.mark.parametrize("each", members(), ids=lambda each: type(each).__name__)
def test_what_is_straightened_comes_back_far_beyond_the_data(each: InvertibleWarp) -> None:
    t = 4.0 * np.random.default_rng(102).standard_normal((50, 3))
    # A network's error falls at least to 0.9 of itself in each of 200 rounds: 7e-10 of it is left.
    assert np.abs(each.back(each.value(t)) - t).max() < 1e-8


def test_curves_that_would_turn_back_are_made_monotone() -> None:
    steep = flat_curves(1, 5, 2.5).at(np.full(5, 3.0))
    t = np.linspace(-5.0, 5.0, 400)[:, None]
    # The least slope that is left is 0.1, at one of 101 points; between them it is not far from it.
    slopes = np.diff(steep.value(t)[:, 0]) / np.diff(t[:, 0])
    assert 0.05 < slopes.min() < 0.15


def test_a_network_without_an_inverse_is_shrunk_until_it_has_one() -> None:
    wild = idle_network(3, 6, np.random.default_rng(103))
    tamed = wild.at(wild.parameters + 5.0)
    steep = np.linalg.norm(tamed.out, 2) * np.linalg.norm(tamed.into, 2)
    assert steep == pytest.approx(0.9)


@pytest.mark.parametrize("spoil", ["height", "width", "centre"])
def test_curves_from_a_file_that_have_no_inverse_are_refused(spoil: str) -> None:
    good = {k: np.array(v) for k, v in flat_curves(2, 3, 2.0).weights().items()}
    bad = {"height": np.full((2, 3), 9.0), "width": np.array(-1.0), "centre": np.zeros(6)}
    assert isinstance(straight_of(good), Curves)
    with pytest.raises(MapError, match=r"makes no curves and no network with an inverse"):
        straight_of(good | {spoil: bad[spoil]})


def test_a_network_from_a_file_that_has_no_inverse_is_refused() -> None:
    good = dict(idle_network(2, 3, np.random.default_rng(104)).weights())
    assert isinstance(straight_of(good), NetworkWarp)
    with pytest.raises(MapError, match=r"bias, into, out makes no curves"):
        straight_of(good | {"out": np.full((2, 3), 9.0)})
