"""The mixture of priors against integrals made by other means."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from morph.model.gaussian.information import Information
from morph.model.kwik.belief import (
    UNCHANGED,
    ModelPosterior,
    belief,
    evidence,
    sized,
    widths,
)


def seen(size: int, rows: int, seed: int = 100) -> tuple[Information, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    Z, z = rng.normal(size=(rows, size)), rng.normal(size=rows)
    return Information(H=Z.T @ Z, b=Z.T @ z, c=float(z @ z)), Z, z


def test_weights_integrated_out_leave_the_marginal_density() -> None:
    found, Z, z = seen(5, 8)
    part = sized(found, 2, np.full(3, 0.7))
    for theta in (np.zeros(2), np.array([0.5, -1.0])):
        # z - Z_named theta is normal with covariance I + size^2 Z_w Z_w'.
        covariance = np.eye(8) + 0.49 * Z[:, 2:] @ Z[:, 2:].T
        off = z - Z[:, :2] @ theta
        exact = -0.5 * off @ np.linalg.solve(covariance, off)
        exact -= 0.5 * np.linalg.slogdet(covariance)[1]
        r = part.reduced
        ours = -0.5 * (r.c - 2.0 * r.b @ theta + theta @ r.H @ theta)
        assert ours == pytest.approx(exact, abs=1e-9)


def test_the_evidence_of_a_rival_is_the_integral_over_its_prior() -> None:
    found, Z, z = seen(1, 6)
    log, mean, covariance = evidence(found, np.array([[0.4]]))

    def density(theta: float) -> float:
        return float(np.exp(-0.5 * ((z - Z[:, 0] * theta) ** 2).sum()) * norm.pdf(theta, scale=0.4))

    whole = quad(density, -4.0, 4.0)[0]
    first = quad(lambda x: x * density(x), -4.0, 4.0)[0] / whole
    second = quad(lambda x: x * x * density(x), -4.0, 4.0)[0] / whole
    # scipy's quadrature promises 1.5e-8.
    assert log[0] == pytest.approx(np.log(whole), abs=1e-7)
    assert mean[0, 0] == pytest.approx(first, abs=1e-7)
    assert covariance[0, 0, 0] == pytest.approx(second - first**2, abs=1e-7)


def test_a_rival_without_width_changes_nothing() -> None:
    found, _, _ = seen(3, 9)
    log, mean, covariance = evidence(found, np.zeros((1, 3)))
    assert log[0] == pytest.approx(-0.5 * found.c)
    assert not mean.any()
    assert not covariance.any()


def test_priors_of_all_rivals_add_up_to_one() -> None:
    width, log_prior = widths(4)
    assert np.exp(log_prior).sum() == pytest.approx(1.0)
    assert not width[0].any()
    assert np.exp(log_prior[0]) == pytest.approx(UNCHANGED)


def test_draws_have_the_mean_and_covariance_of_the_mixture() -> None:
    held = believed()
    drawn = held.draws(40_000, np.random.default_rng(3))
    weight = held.weight
    mean = np.einsum("sr,srp->p", weight, held.mean)
    second = np.einsum(
        "sr,srpq->pq", weight, held.covariance + held.mean[..., :, None] * held.mean[..., None, :]
    )
    covariance = second - np.outer(mean, mean)
    deviation = np.sqrt(np.diag(covariance))
    # A mean of 40000 draws has a standard error of 0.005 deviations; 5 of them.
    assert (np.abs(drawn[:, :2].mean(axis=0) - mean) < 0.025 * deviation).all()
    # Tails are heavier than a normal's: a few times sqrt(2 / 40000) = 0.7 %.
    np.testing.assert_allclose(np.cov(drawn[:, :2].T), covariance, atol=0.05 * deviation.max() ** 2)


def test_probabilities_of_rivals_add_up_to_one() -> None:
    assert believed().weight.sum() == pytest.approx(1.0)


def believed() -> ModelPosterior:
    found, _, _ = seen(5, 30)
    return belief(found, 2, np.ones(2), 1)
