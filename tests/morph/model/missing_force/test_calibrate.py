from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from morph.model.missing_force.calibrate import _likeliest, calibration, ranks


def test_a_right_forecast_is_calibrated() -> None:
    rng = np.random.default_rng(0)
    found = calibration(ranks(rng.normal(size=(99, 20_000)), rng.normal(size=20_000)))
    # Each share errs by at most sqrt(1/4 / 20000) = 0.0035.
    assert found.error < 0.01
    assert found.covered(0.96) == pytest.approx(0.96, abs=0.012)


def test_a_forecast_twice_too_sure_covers_what_a_closed_form_says() -> None:
    rng = np.random.default_rng(1)
    found = calibration(ranks(0.5 * rng.normal(size=(199, 20_000)), rng.normal(size=20_000)))
    inside = 2.0 * norm.cdf(0.5 * norm.ppf(0.98)) - 1.0  # 0.696
    assert found.covered(0.96) == pytest.approx(inside, abs=0.015)
    off = norm.cdf(0.5 * norm.ppf(found.level)) - found.level
    assert found.error == pytest.approx(np.sqrt((off**2).mean()), abs=0.01)


def test_a_draw_that_ran_away_counts_as_none() -> None:
    draws = np.array([[0.0], [1.0], [np.nan], [np.nan]])
    # One of two is below 0.5: (1 + 0.5) / 3.
    assert ranks(draws, np.array([0.5])) == pytest.approx(0.5)


@pytest.mark.parametrize("times", [1.0, 3.0])
def test_errors_so_many_times_too_large_ask_for_that_scale(times: float) -> None:
    rng = np.random.default_rng(2)
    spread = np.full((40, 20, 4), 0.3)
    still = np.full_like(spread, 0.01)
    error = rng.normal(size=spread.shape) * np.sqrt(still + times**2 * spread)
    # 40 blocks of 4 numbers, each worth 3 errors: 480, so 1 / sqrt(960) = 0.03 of it.
    assert _likeliest(error, spread, still) == pytest.approx(times, rel=0.12)
