from __future__ import annotations

import numpy as np
import pytest

from morph.arrays import Array
from morph.errors import DiagnosisError
from morph.model.latent.run import Run
from morph.model.transition_gp import Mapped, _periods, fit_map

NOISE = np.array([0.01, 0.02])


def _closed(state: Array, command: Array) -> Array:
    """A mass on a spring, as a simulator has it."""
    q, v = state.T
    push = command[:, 0] - q
    return np.column_stack([q + 0.1 * v, v + 0.1 * push])


def _true(state: Array, command: Array) -> Array:
    """The same with a drag that grows with the speed."""
    after = _closed(state, command)
    after[:, 1] -= 0.1 * np.tanh(2.0 * state[:, 1])
    return after


def _run(seed: int, periods: int = 50) -> tuple[Run, Array]:
    rng = np.random.default_rng(seed)
    command = np.repeat(rng.uniform(-2.0, 2.0, (periods // 5, 1)), 5, axis=0)
    states = [np.zeros(2)]
    for told in command:
        states.append(_true(states[-1][None], told[None])[0])
    true = np.array(states)
    seen = true + NOISE * rng.normal(size=true.shape)
    run = Run(position=seen[:, :1], velocity=seen[:, 1:], command=command, period=0.1)
    return run, true


@pytest.fixture(scope="module")
def learned() -> Mapped:
    return fit_map(_closed, [_run(0)[0], _run(1)[0]], NOISE)


def test_a_map_comes_nearer_than_the_simulator_and_says_how_near(learned: Mapped) -> None:
    run, true = _run(2)
    state, after = true[:-1], true[1:]
    off = learned.mean(state, run.command) - after
    alone = _closed(state, run.command) - after
    assert np.sqrt((off[:, 1] ** 2).mean()) < 0.35 * np.sqrt((alone[:, 1] ** 2).mean())
    spread = np.sqrt(learned.variance(state, run.command))
    # Nine of ten within twice the standard deviation; a normal distribution would have 0.954.
    assert (np.abs(off) < 2.0 * spread + 1e-4).mean() > 0.9


def test_the_noise_of_one_observation_is_in_two_errors() -> None:
    rng = np.random.default_rng(3)
    run, true = _run(4, periods=5)
    *_, covariance = _periods(_closed, run, NOISE)
    seen = true + NOISE * rng.normal(size=(40_000, *true.shape))
    flat, told = seen[:, :-1].reshape(-1, 2), np.tile(run.command, (40_000, 1))
    error = seen[:, 1:] - _closed(flat, told).reshape(-1, 5, 2)
    sampled = np.cov(error.reshape(len(error), -1).T)
    # Products of errors of variance up to 8e-4, averaged over 40000: 8e-4 / 200 = 4e-6, 5 of it.
    assert covariance == pytest.approx(sampled, abs=2e-5)
    assert covariance[1, 3] < -3e-4


def test_draws_have_the_mean_and_the_variance_of_the_map(learned: Mapped) -> None:
    rng = np.random.default_rng(5)
    state, command = _run(6)[1][10:14], _run(6)[0].command[10:14]
    law = learned._drawn(1500, rng)
    z = learned.look(state, command, _closed(state, command))
    drawn = law(np.broadcast_to(z, (1500, *z.shape)))
    mean = learned.mean(state, command) - _closed(state, command)
    variance = learned.variance(state, command) - learned.jump**2
    # Means err by s / sqrt(1500); the variance of draws by sqrt(2 / 1500) = 3.7 % and by what 256
    # waves miss of the kernel.
    spread = np.sqrt(variance)
    assert drawn.mean(axis=0) == pytest.approx(mean, abs=0.1 * float(spread.max()))
    assert drawn.var(axis=0) == pytest.approx(variance, rel=0.3, abs=1e-8)


def test_forecasts_begin_where_runs_begin_and_keep_their_shape(learned: Mapped) -> None:
    run, true = _run(7)
    seen = learned.foresee(true[:1], run.command[None, :20], np.random.default_rng(0), draws=50)
    assert seen.shape == (50, 1, 21, 2)
    assert seen[:, 0, 0].mean(axis=0) == pytest.approx(true[0], abs=4.0 * 0.02 / np.sqrt(50.0))
    off = np.abs(seen.mean(axis=0)[0] - true[:21])
    assert (off < 4.0 * np.sqrt(seen.var(axis=0)[0]) + 1e-3).all()


def test_more_than_can_be_learned_from_is_refused() -> None:
    run = _run(0)[0]
    with pytest.raises(DiagnosisError, match="4000 numbers"):
        fit_map(_closed, [run] * 40, NOISE)
