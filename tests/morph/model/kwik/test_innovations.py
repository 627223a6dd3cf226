"""The filter with sensitivities against the joint normal distribution of all observations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.stats import multivariate_normal

from morph.arrays import Array
from morph.model.kwik.innovations import Account, account

PERIODS, STATES, UNKNOWNS = 7, 2, 3
NOISE = np.array([0.1, 0.2])
UNSAID = np.array([0.02, 0.05])


def linear() -> tuple[Array, Array]:
    rng = np.random.default_rng(100)
    A = np.stack([expm(0.3 * rng.normal(size=(STATES, STATES))) for _ in range(PERIODS)])
    return A, rng.normal(size=(PERIODS, STATES, UNKNOWNS))


def simulated(theta: Array, rng: np.random.Generator) -> Array:
    """Return noisy readings of x_(t+1) = A_t x_t + B_t theta + w_t."""
    A, B = linear()
    x = [rng.normal(size=STATES)]
    for t in range(PERIODS):
        x.append(A[t] @ x[-1] + B[t] @ theta + UNSAID * rng.normal(size=STATES))
    return np.array(x) + NOISE * rng.normal(size=(PERIODS + 1, STATES))


def accounted(reading: Array) -> Account:
    A, B = linear()
    ahead = np.einsum("tij,tj->ti", A, reading[:-1])
    return account(reading, ahead, A, B, noise=NOISE, unsaid=UNSAID)


def joint(reading: Array, theta: Array) -> float:
    """Return log p(y_1 .. y_T | y_0, theta), all of it in one normal distribution."""
    A, B = linear()
    # x_0 = y_0 + noise; every later reading is linear in x_0, theta, w and its own noise.
    middle, spread = [reading[0]], [np.diag(NOISE)]
    columns = STATES * (1 + PERIODS)
    spread = [np.hstack([np.diag(NOISE), np.zeros((STATES, columns - STATES))])]
    for t in range(PERIODS):
        middle.append(A[t] @ middle[-1] + B[t] @ theta)
        row = A[t] @ spread[-1]
        at = STATES * (1 + t)
        row[:, at : at + STATES] += np.diag(UNSAID)
        spread.append(row)
    wide = np.concatenate(spread[1:])
    covariance = wide @ wide.T + np.diag(np.tile(NOISE**2, PERIODS))
    return float(
        multivariate_normal.logpdf(reading[1:].ravel(), np.concatenate(middle[1:]), covariance)
    )


def log_likelihood(found: Account, theta: Array) -> float:
    return -0.5 * float(((found.surprise - found.slope @ theta) ** 2).sum())


def test_the_account_is_the_joint_density_of_all_readings_up_to_a_constant() -> None:
    rng = np.random.default_rng(101)
    reading = simulated(np.array([0.3, -0.2, 0.5]), rng)
    found = accounted(reading)
    thetas = [np.zeros(UNKNOWNS), *np.eye(UNKNOWNS), np.array([0.3, -0.2, 0.5])]
    gaps = [joint(reading, theta) - log_likelihood(found, theta) for theta in thetas]
    # Both are sums of 14 terms of order 100 in double precision.
    np.testing.assert_allclose(gaps, gaps[0], atol=1e-8)


def test_surprises_under_the_true_unknowns_are_independent_and_standard() -> None:
    rng = np.random.default_rng(102)
    theta = np.array([0.3, -0.2, 0.5])
    draws = []
    for _ in range(500):
        found = accounted(simulated(theta, rng))
        draws.append((found.surprise - found.slope @ theta).ravel())
    covariance = np.cov(np.array(draws).T)
    # A covariance of 500 draws has a standard error of sqrt(2 / 500) = 0.063 on the diagonal and
    # 0.045 beside it; the largest of 14 x 15 / 2 = 105 is within 4.5 of them.
    np.testing.assert_allclose(covariance, np.eye(PERIODS * STATES), atol=0.28)


@pytest.mark.parametrize("count", [1, 4])
def test_an_account_of_the_past_does_not_change_with_the_future(count: int) -> None:
    reading = simulated(np.zeros(UNKNOWNS), np.random.default_rng(103))
    later = reading.copy()
    later[count + 1 :] += 5.0
    np.testing.assert_array_equal(
        accounted(reading).surprise[:count], accounted(later).surprise[:count]
    )
