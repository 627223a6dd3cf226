"""Quadratics of unknowns against normal distributions of all that was observed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from morph.model.gaussian.information import Information


def test_the_evidence_is_that_of_a_linear_regression() -> None:
    rng = np.random.default_rng(8)
    X, noise, start = rng.normal(size=(7, 3)), 0.4, np.array([0.5, -1.0, 0.2])
    variance = np.array([2.0, 0.5, 1.0])
    y = rng.normal(size=7)
    D, b, c = X.T @ X / noise**2, X.T @ y / noise**2, float(y @ y) / noise**2
    c += 7.0 * np.log(2.0 * np.pi * noise**2)
    found = Information(H=D, b=b, c=c).with_prior(start, variance)
    exact = multivariate_normal.logpdf(
        y, X @ start, X @ np.diag(variance) @ X.T + noise**2 * np.eye(7)
    )
    assert found.log_evidence == pytest.approx(exact, rel=1e-10)


def test_draws_have_the_posteriors_mean_and_covariance() -> None:
    rng = np.random.default_rng(9)
    half = rng.normal(size=(3, 3))
    D = half @ half.T
    told = Information(H=D, b=np.array([1.0, 2.0, 3.0]), c=0.0)
    found = told.with_prior(np.zeros(3), np.ones(3))
    drawn = found.drawn(40_000, rng, scale=2.0)
    exact = 4.0 * np.linalg.inv(D + np.eye(3))
    # Means err by 2 / sqrt(40000) = 0.01, covariances by up to 4 sqrt(2 / 40000) = 0.03.
    assert drawn.mean(axis=0) == pytest.approx(found.mean, abs=0.05)
    assert np.cov(drawn.T) == pytest.approx(exact, abs=0.12)


def test_a_prior_of_the_last_unknowns_leaves_the_first_free() -> None:
    rng = np.random.default_rng(10)
    X, y = rng.normal(size=(9, 4)), rng.normal(size=9)
    told = Information(H=X.T @ X, b=X.T @ y, c=float(y @ y))
    found, inner = told.with_prior(np.zeros(2), np.array([0.3, 2.0])).first(2)
    assert inner == pytest.approx(np.linalg.inv(X[:, 2:].T @ X[:, 2:] + np.diag([1 / 0.3, 0.5])))
    # Weights integrated out are further noise of the readings.
    noise = np.eye(9) + X[:, 2:] @ np.diag([0.3, 2.0]) @ X[:, 2:].T
    for theta in (np.zeros(2), np.array([0.4, -1.0])):
        exact = -2.0 * multivariate_normal.logpdf(y, X[:, :2] @ theta, noise)
        assert found.missed(theta) + 9.0 * np.log(2.0 * np.pi) == pytest.approx(exact)


def test_information_about_a_point_is_that_of_the_unknowns_less_it() -> None:
    rng = np.random.default_rng(11)
    half, point, theta = rng.normal(size=(3, 3)), rng.normal(size=3), rng.normal(size=3)
    told = Information(H=half @ half.T, b=rng.normal(size=3), c=0.7)
    assert told.about(point).missed(theta) == pytest.approx(told.missed(theta - point))
    assert (told + told).missed(theta) == pytest.approx(2.0 * told.missed(theta))
    assert told.through(half).missed(theta) == pytest.approx(told.missed(half @ theta))
