"""Landmarks."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.errors import SamplesError
from morph.alignment.pairs import posed, shuffled, spread_out
from morph.alignment.samples import Pairs


def test_rows_to_label_lie_far_apart() -> None:
    # Three clusters, 100 apart in their spreads of 1: three labels find all three.
    rng = np.random.default_rng(0)
    middle = np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]])
    x = np.repeat(middle, 20, axis=0) + rng.standard_normal((60, 2))
    for seed in range(5):
        rows = spread_out(x, 3, np.random.default_rng(seed))
        assert set(rows // 20) == {0, 1, 2}


def test_a_posed_source_looks_like_the_target() -> None:
    rng = np.random.default_rng(1)
    C_s, C_t = rng.standard_normal((2, 4)), rng.standard_normal((2, 6))
    pairs = posed(rng.standard_normal((40, 6)), C_s, C_t, 5, rng, error=0.0)
    np.testing.assert_allclose(pairs.source @ C_s.T, pairs.target @ C_t.T, atol=1e-12)


def test_a_labeller_errs_by_a_share_of_the_spread() -> None:
    # 400 labels: the standard deviation of their errors is known to 1 / sqrt(800) = 3.5 %.
    rng = np.random.default_rng(2)
    target = 3.0 * rng.standard_normal((400, 1))
    pairs = posed(target, np.eye(1), np.eye(1), 400, rng, error=0.1)
    off = pairs.source - pairs.target
    assert off.std() == pytest.approx(0.1 * target.std(), rel=0.12)


@pytest.mark.parametrize("count", [2, 3, 10])
def test_shuffled_pairs_leave_no_row_with_its_own(count: int) -> None:
    pairs = Pairs(source=np.arange(float(count))[:, None], target=np.arange(float(count))[:, None])
    for seed in range(20):
        wrong = shuffled(pairs, np.random.default_rng(seed))
        assert (wrong.source != wrong.target).all()
        assert sorted(wrong.source[:, 0]) == sorted(pairs.source[:, 0])


def test_more_labels_than_states_are_refused() -> None:
    with pytest.raises(SamplesError, match=r"5 of 3 states"):
        spread_out(np.zeros((3, 2)), 5, np.random.default_rng(0))


def test_looks_of_different_numbers_are_refused() -> None:
    with pytest.raises(SamplesError, match=r"1 numbers are looked at on the source, 2 on the"):
        posed(np.zeros((3, 2)), np.eye(1), np.eye(2), 2, np.random.default_rng(0))
