"""Beliefs of linear bodies, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.samples import Transitions
from morph.errors import TransferError
from morph.policy_transfer.linear_belief import LinearBelief, anew, readings, regressed, regulator


def moved(
    A: np.ndarray, B: np.ndarray, count: int, *, noise: float = 0.0, seed: int = 0
) -> Transitions:
    """Return one run of random commands."""
    rng = np.random.default_rng(seed)
    command = rng.standard_normal((count, B.shape[1]))
    states = [np.zeros(len(A))]
    for each in command:
        states.append(A @ states[-1] + B @ each)
    seen = np.array(states) + noise * rng.standard_normal((count + 1, len(A)))
    return Transitions(
        state=seen[:-1], command=command, after=seen[1:], turns=np.zeros(len(A), dtype=bool)
    )


PERIOD = 0.02
A = np.array([[1.0, PERIOD], [0.3 * PERIOD, 1.0]])
B = np.array([[0.0], [2.0 * PERIOD]])


def test_one_reading_makes_one_number_as_sure_as_the_closed_form_says() -> None:
    # x' = x + b u from any x_0: y_1 - y_0 = b u + noise of variance 2 s^2, so the precision of b
    # is 1 / 0.5^2 + u^2 / (2 s^2) and its mean u (y_1 - y_0) / (2 s^2) over that.
    def model(point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.array([[1.0, point[0]]]), np.array([[0.0], [1.0]])

    seen = Transitions(
        state=np.array([[0.1]]),
        command=np.array([[2.0]]),
        after=np.array([[0.7]]),
        turns=np.zeros(1, dtype=bool),
    )
    before = LinearBelief(model=model, mean=np.zeros(1), covariance=np.array([[0.25]]))
    after = before.seen(seen, noise=0.1)
    precision = 4.0 + 4.0 / 0.02
    assert after.covariance[0, 0] == pytest.approx(1.0 / precision, rel=1e-9)
    assert after.mean[0] == pytest.approx(2.0 * 0.6 / 0.02 / precision, rel=1e-6)


def test_a_body_is_learned_anew_without_noise() -> None:
    seen = moved(A, B, 40)
    # Readings are exact; the noise that is told weighs what was known before, by 1e-6 or less.
    found = anew(seen, PERIOD, noise=1e-6)
    assert np.abs(found - np.concatenate([A, B], axis=1)).max() < 1e-4
    assert np.abs(regressed(seen) - np.concatenate([A, B], axis=1)).max() < 1e-4


def test_whole_runs_tell_more_than_steps_under_noise() -> None:
    # Noise in a regressor draws its weight to zero; a run's own state has none.
    truth = np.concatenate([A, B], axis=1)
    errors = {"anew": 0.0, "regressed": 0.0}
    for seed in range(5):
        seen = moved(A, B, 100, noise=0.02, seed=seed)
        errors["anew"] += np.abs(anew(seen, PERIOD, noise=0.02) - truth).max()
        errors["regressed"] += np.abs(regressed(seen) - truth).max()
    assert errors["anew"] < 0.5 * errors["regressed"]


def test_runs_end_where_the_next_transition_begins_elsewhere() -> None:
    seen = moved(A, B, 12).and_also(moved(A, B, 5, seed=1))
    assert [len(command) for _, command in readings(seen)] == [12, 5]


def test_what_no_command_moves_is_held_by_nothing() -> None:
    W = np.array([[1.5, 0.0, 0.0], [0.0, 0.9, 1.0]])
    bounds = (np.array([-1.0]), np.array([1.0]))
    assert not regulator(W, np.eye(2), bounds, noise=0.01).any()


def test_a_covariance_of_another_size_is_refused() -> None:
    with pytest.raises(TransferError, match=r"shape \(2, 2\), and it has 1 numbers"):
        LinearBelief(model=lambda _: (A, B), mean=np.zeros(1), covariance=np.eye(2))
