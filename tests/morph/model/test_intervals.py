"""Intervals of a fit against those of a mean, as textbooks have them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from morph.model.fit import Fit


def mean_of(values: np.ndarray, curve: float, *, low: float = -9.0, high: float = 9.0) -> Fit:
    """Return the fit of one number m to values, a segment each, of the losses curve (m - x)^2."""
    middle = float(values.mean())
    quadratic = SimpleNamespace(
        hessian=np.full((len(values), 1, 1), curve),
        slope=curve * (values - middle)[:, None],
        loss=curve * (values - middle) ** 2,
    )
    hypothesis = SimpleNamespace(
        low=np.array([low]),
        high=np.array([high]),
        trust=np.array([1e-9]),
        likely=np.array([np.nan]),
        knobs=(),
    )
    none = cast(Any, None)
    return Fit(
        hypothesis=cast(Any, hypothesis),
        point=np.array([middle]),
        start=none,
        scale=none,
        weight=none,
        around=none,
        quadratic=cast(Any, quadratic),
    )


@pytest.mark.parametrize("curve", [1.0, 40.0])
def test_the_interval_of_a_mean_is_its_standard_error_times_that_of_90_percent(
    curve: float,
) -> None:
    values = np.random.default_rng(0).normal(0.7, 0.3, 12)
    low, high = mean_of(values, curve).intervals()
    # 90 % of a normal distribution lie within 1.645 deviations.
    error = 1.645 * values.std(ddof=1) / np.sqrt(12)
    assert low[0] == pytest.approx(values.mean() - error, rel=1e-6)
    assert high[0] == pytest.approx(values.mean() + error, rel=1e-6)


def test_an_interval_ends_where_the_parameter_does() -> None:
    values = np.array([0.0, 0.2, 0.1, 0.3])
    low, high = mean_of(values, 1.0, low=0.1, high=0.16).intervals()
    assert (low[0], high[0]) == (0.1, 0.16)
