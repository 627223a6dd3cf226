"""Bets on a linear-Gaussian toy: never won too often, however one stops, and won when right."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from morph.arrays import Array
from morph.model.gaussian.information import Information
from morph.model.kwik.belief import WIDE, belief, sized
from morph.model.kwik.e_values import bets, distances, worst

DELTA = 0.05
NEEDED = float(np.log(1.0 / DELTA))
UNIT = np.ones(2)
CASES = 100


def toy(seed: int = 100, count: int = 40) -> tuple[Array, Array]:
    """Return slopes of readings and of errors, in two figures and two weights."""
    rng = np.random.default_rng(seed)
    return 30.0 * rng.normal(size=(count, 1, 4)), 8.0 * rng.normal(size=(count, 1, 4))


def information(Z: Array, z: Array) -> Information:
    flat = Z.reshape(-1, Z.shape[-1])
    return Information(H=flat.T @ flat, b=flat.T @ z.ravel(), c=float((z**2).sum()))


def won(theta: Array, rng: np.random.Generator, most: int) -> tuple[Array, Array, bool]:
    """Return both bets after each reading, and whether the model is good on all of them."""
    Z, error = toy()
    z = Z @ theta + rng.standard_normal(Z.shape[:2])
    both = [
        bets(belief(information(Z[:t], z[:t]), 2, UNIT, 1), UNIT, error, most)
        for t in (5, 10, 20, 40)
    ]
    beyond = int((np.abs(error @ theta).max(axis=1) >= 1.0).sum())
    return np.array([b[0] for b in both]), np.array([b[1] for b in both]), beyond < most


def scaled_to(direction: Array, beyond: float, most: int) -> Array:
    """Return figures at which the most-th largest error is `beyond` epsilons."""
    _, error = toy()
    theta = np.concatenate([direction, np.zeros(2)])
    return theta * beyond / worst(np.abs(error @ theta).max(axis=1), most)


@pytest.mark.parametrize("most", [1, 3])
def test_a_model_just_not_good_is_accepted_at_any_moment_in_at_most_delta(most: int) -> None:
    rng = np.random.default_rng(104)
    wrong = 0
    for number in range(CASES):
        angle = 2.0 * np.pi * number / CASES
        theta = scaled_to(np.array([np.cos(angle), np.sin(angle)]), 1.001, most)
        for_good, _, good = won(theta, rng, most)
        assert not good
        wrong += bool((for_good >= NEEDED).any())
    # At most 5 % of 100 = 5; a binomial has a deviation of 2.2, so 5 + 3 * 2.2.
    assert wrong <= 11


@pytest.mark.parametrize("most", [1, 3])
def test_a_model_just_good_is_rejected_at_any_moment_in_at_most_delta(most: int) -> None:
    rng = np.random.default_rng(105)
    wrong = 0
    for number in range(CASES):
        angle = 2.0 * np.pi * number / CASES
        theta = scaled_to(np.array([np.cos(angle), np.sin(angle)]), 0.999, most)
        _, for_bad, good = won(theta, rng, most)
        assert good
        wrong += bool((for_bad >= NEEDED).any())
    assert wrong <= 11


def test_an_unchanged_model_and_one_far_off_are_both_told_in_the_end() -> None:
    rng = np.random.default_rng(106)
    right = wrong = 0
    for _ in range(20):
        for_good, _, _ = won(np.zeros(4), rng, 1)
        _, for_bad, _ = won(scaled_to(np.array([1.0, 0.5]), 4.0, 1), rng, 1)
        right += bool(for_good[-1] >= NEEDED)
        wrong += bool(for_bad[-1] >= NEEDED)
    # Figures are known to 1 / (30 sqrt(40)) = 0.005, and errors of slope 8 in four unknowns to
    # 0.08 epsilon, at worst some 0.2: five deviations from epsilon, so nearly all are told.
    assert right >= 17
    assert wrong >= 19


def test_against_a_known_figure_a_bet_is_a_martingale() -> None:
    """The mean of p(data | mixture) / p(data | theta) under theta is 1, at every moment."""
    rng = np.random.default_rng(107)
    Z, _ = toy()
    Z = 0.01 * Z
    theta = np.array([0.1, -0.2, 0.0, 0.0])
    ratios = []
    for _ in range(1500):
        # The weights are drawn as the prior has them, here of a single size.
        beta = 0.5 * rng.standard_normal(2)
        z = Z @ (theta + np.concatenate([np.zeros(2), beta])) + rng.standard_normal(Z.shape[:2])
        found = information(Z[:12], z[:12])
        held = belief(found, 2, UNIT, 1, ((0.5, 0.5, 1.0),))
        part = sized(found, 2, np.full(2, 0.5))
        r = part.reduced
        log = -0.5 * (r.c - 2.0 * r.b @ theta[:2] + theta[:2] @ r.H @ theta[:2])
        ratios.append(np.exp(held.log_evidence - log))
    drawn = np.array(ratios)
    # Four standard errors.
    assert abs(drawn.mean() - 1.0) < 4.0 * drawn.std() / np.sqrt(len(drawn))


def test_the_distance_to_one_error_is_that_of_a_constrained_search() -> None:
    rng = np.random.default_rng(108)
    Z, error = toy(count=10)
    found = information(0.05 * Z, rng.standard_normal((10, 1)))
    part = sized(found, 2, np.full(2, 0.5))
    _, out, _ = distances(part, UNIT, 0.02 * error)
    trust = np.diag([WIDE**-2.0, WIDE**-2.0, 4.0, 4.0])
    whole = found.H + trust
    middle = np.linalg.solve(whole, found.b)

    def off(theta: Array) -> float:
        return float((theta - middle) @ whole @ (theta - middle))

    for at in range(10):
        row = 0.02 * error[at, 0]
        found_by_search = []
        for sign in (1.0, -1.0):
            limit = {"type": "ineq", "fun": lambda x, s=sign, r=row: s * r @ x - 1.0}
            searched = minimize(off, middle, constraints=limit, options={"ftol": 1e-12})
            found_by_search.append(np.sqrt(max(searched.fun, 0.0)))
        # SLSQP ends within the square root of its tolerance.
        assert out[at] == pytest.approx(min(found_by_search), abs=1e-4)


def test_the_worst_counts_from_the_largest() -> None:
    errors = np.array([[3.0, 1.0, 2.0], [0.0, 5.0, 4.0]])
    np.testing.assert_array_equal(worst(errors, 1), [3.0, 5.0])
    np.testing.assert_array_equal(worst(errors, 3), [1.0, 0.0])
