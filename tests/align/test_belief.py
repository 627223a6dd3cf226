"""What few noisy transitions tell of a linear body whose law is known."""

from __future__ import annotations

import numpy as np
import pytest

from morph.alignment.arrays import Array
from morph.alignment.belief import Belief, believed, mechanical
from morph.alignment.errors import SamplesError, SettingError
from morph.alignment.samples import Transitions

PERIOD = 0.02
NOISE = np.full(2, 0.01)
# A pendulum that falls at 9.81 m/s2 over half a metre: 19.62 /s2; a command gives 5 rad/s2.
TRUTH = (19.62, 5.0)


def law() -> Array:
    base, lift, _ = mechanical(1, np.ones(1), PERIOD)
    return np.asarray(base + lift @ (PERIOD * np.array([[TRUTH[0], 0.0, TRUTH[1]]])))


def transitions(seed: int, *, runs: int = 4, length: int = 15) -> Transitions:
    rng, F = np.random.default_rng(seed), law()
    state, command, after = [], [], []
    for _ in range(runs):
        x = 0.02 * rng.standard_normal(2)
        reading = x + NOISE * rng.standard_normal(2)
        for _ in range(length):
            u = rng.standard_normal(1)
            x = F @ np.concatenate([x, u])
            seen = x + NOISE * rng.standard_normal(2)
            state.append(reading), command.append(u), after.append(seen)
            reading = seen
    turns = np.zeros(2, dtype=bool)
    return Transitions(
        state=np.array(state), command=np.array(command), after=np.array(after), turns=turns
    )


def belief(seen: Transitions) -> Belief:
    base, lift, wide = mechanical(1, np.ones(1), PERIOD)
    return believed(seen, noise=NOISE, base=base, lift=lift, wide=wide)


def test_the_mechanical_law_integrates_a_constant_acceleration_exactly() -> None:
    # v' = v + a T, q' = q + v T + a T^2 / 2, with a = 3 u, q = 1, v = 2, u = 1.
    base, lift, _ = mechanical(1, np.ones(1), PERIOD)
    F = base + lift @ (PERIOD * np.array([[0.0, 0.0, 3.0]]))
    after = F @ np.array([1.0, 2.0, 1.0])
    assert after == pytest.approx([1.0 + 2.0 * 0.02 + 1.5 * 0.02**2, 2.06], abs=1e-12)


def test_sixty_noisy_transitions_tell_the_law_within_what_the_belief_says() -> None:
    # Squares of three errors in standard deviations, over eight draws: 24 numbers of mean 1 and
    # variance 2, so their mean is beyond 1 + 4 sqrt(2 / 24) = 2.15 once in ten thousand times.
    squares, errors = [], []
    for seed in range(8):
        found = belief(transitions(seed))
        off = PERIOD * np.array([TRUTH[0], 0.0, TRUTH[1]]) - found.mean[0]
        squares.append(np.square(np.linalg.solve(found.root, off)).mean())
        errors.append(abs(off[2]) / (PERIOD * TRUTH[1]))
    assert np.mean(squares) < 2.15
    assert np.median(errors) < 0.15


def test_least_squares_is_further_from_the_law_than_a_belief_that_knows_of_noise() -> None:
    ours, theirs = [], []
    for seed in range(5):
        seen = transitions(seed)
        z = np.concatenate([seen.state, seen.command], axis=1)
        plain = np.linalg.lstsq(z, seen.after, rcond=None)[0].T
        ours.append(np.abs(belief(seen).law - law())[1].sum())
        theirs.append(np.abs(plain - law())[1].sum())
    assert np.mean(ours) < 0.5 * np.mean(theirs)


def test_draws_have_the_mean_and_the_covariance_of_the_belief() -> None:
    found = belief(transitions(3))
    drawn = found.drawn(4000, np.random.default_rng(0))[:, 1, :] - found.law[1]
    # Standard deviations of 4000 draws are right to 1 / sqrt(8000) = 1.1 %; five of these.
    spread = np.sqrt(np.diag(found.root @ found.root.T))
    assert drawn.std(axis=0) == pytest.approx(spread, rel=0.056)
    # Means to 1 / sqrt(4000) = 1.6 % of a standard deviation; five of these.
    assert np.abs(drawn.mean(axis=0) / spread).max() < 0.08


def test_too_few_transitions_are_refused() -> None:
    with pytest.raises(SamplesError, match=r"5 transitions say nothing of 2 states"):
        belief(transitions(0, runs=1, length=5))


def test_a_command_that_never_changed_is_refused() -> None:
    seen = transitions(0)
    held = Transitions(
        state=seen.state, command=0.0 * seen.command, after=seen.after, turns=seen.turns
    )
    with pytest.raises(SamplesError, match=r"command 0 never changed"):
        belief(held)


def test_readings_without_noise_are_refused() -> None:
    with pytest.raises(SettingError, match=r"give 2 standard deviations above 0"):
        believed(transitions(0), noise=np.zeros(2))
