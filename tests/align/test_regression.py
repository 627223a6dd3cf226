"""A linear law and a smooth rest, from few data."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.errors import SamplesError
from morph.alignment.regression import MOST_DATA, _Evidence, regression


def test_a_linear_law_goes_on_far_beyond_the_data() -> None:
    rng = np.random.default_rng(0)
    x = rng.normal(size=(60, 3))
    y = 0.7 * x[:, 1] + 0.05 * rng.normal(size=60)
    found = regression(x, y)
    # Each weight is known to 0.05 / sqrt(60) = 0.006; three of that, and what the prior takes.
    assert found.linear == pytest.approx([0.0, 0.0, 0.7, 0.0], abs=0.03)
    mean, _ = found.predict(np.array([[0.0, 10.0, 0.0]]))
    assert mean == pytest.approx([7.0], abs=0.4)


def test_a_smooth_rest_is_found_and_fades_out() -> None:
    rng = np.random.default_rng(1)
    x = rng.uniform(-2.0, 2.0, size=(80, 1))
    found = regression(x, np.sin(3.0 * x[:, 0]) + 0.02 * rng.normal(size=80))
    at = np.linspace(-1.8, 1.8, 30)[:, None]
    mean, variance = found.predict(at)
    assert np.abs(mean - np.sin(3.0 * at[:, 0])).max() < 0.1
    far, doubt = found.predict(np.array([[60.0]]))
    law = found.linear @ np.array([1.0, 60.0])
    assert far == pytest.approx([law], abs=1e-9)
    assert doubt[0] > 100.0 * variance.max()


def test_law_and_radial_functions_together_are_the_mean() -> None:
    rng = np.random.default_rng(2)
    x = rng.normal(size=(40, 2))
    found = regression(x, x[:, 0] ** 2 + x[:, 1])
    centre, width, weight = found.bumps
    at = rng.normal(size=(10, 2))
    near = np.exp(-0.5 * np.square((at[:, None] - centre) / width).sum(-1))
    told = found.linear[0] + at @ found.linear[1:] + near @ weight
    # Weights of order 1e2 that cancel: 1e-14 of them.
    assert told == pytest.approx(found.predict(at)[0], abs=1e-8)


def test_the_gradient_of_the_evidence_is_that_of_finite_differences() -> None:
    rng = np.random.default_rng(3)
    x, y = rng.normal(size=(20, 3)), rng.normal(size=20)
    problem = _Evidence(x, y, rng.uniform(0.0, 0.1, 20))
    logs = np.array([-0.3, -0.8, 0.6, -1.2])
    step = 1e-6 * np.eye(4)
    slope = [(problem(logs + each)[0] - problem(logs - each)[0]) / 2e-6 for each in step]
    # Differences of numbers of order 30: 30 * 1e-16 / 1e-6 = 3e-9, and as much of second order.
    assert problem(logs)[1] == pytest.approx(slope, abs=1e-6)


def test_what_is_known_to_be_uncertain_counts_less() -> None:
    x = np.linspace(-1.0, 1.0, 40)[:, None]
    y = 2.0 * x[:, 0]
    y[30:] += 5.0
    doubt = np.where(np.arange(40) >= 30, 100.0, 0.0)
    found = regression(x, y, doubt)
    assert found.predict(np.array([[0.9]]))[0] == pytest.approx([1.8], abs=0.1)


@pytest.mark.parametrize(
    ("inputs", "targets", "what"),
    [
        (np.zeros((2, 1)), np.zeros(2), "there are 2 measurements"),
        (np.zeros((MOST_DATA + 1, 1)), np.zeros(MOST_DATA + 1), "there are 1501"),
        (np.zeros((5, 1)), np.zeros(4), r"shape \(5, 1\), and targets \(4,\)"),
        (np.full((5, 1), np.nan), np.zeros(5), "no finite number"),
    ],
)
def test_data_that_are_none_are_refused(inputs: np.ndarray, targets: np.ndarray, what: str) -> None:
    with pytest.raises(SamplesError, match=what):
        regression(inputs, targets)
