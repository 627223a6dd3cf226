from __future__ import annotations

import numpy as np
import pytest
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from morph.errors import SearchError
from morph.model.gp.fit import Evidence, Priors, fit
from morph.model.gp.gp import GaussianProcess


@pytest.fixture(scope="module")
def known() -> GaussianProcess:
    rng = np.random.default_rng(7)
    inputs = rng.normal(size=(60, 3)) * np.array([1.0, 5.0, 0.2]) + np.array([0.0, 40.0, 1.0])
    targets = np.stack([np.sin(inputs[:, 0]), inputs[:, 1] * inputs[:, 2]], axis=1)
    return GaussianProcess(
        inputs=inputs,
        targets=targets + 0.05 * rng.normal(size=targets.shape),
        lengths=np.array([[1.2, 8.0, 0.7], [3.0, 6.0, 0.4]]),
        signal=np.array([1.1, 45.0]),
        noise=np.array([0.05, 0.3]),
    )


def _second_library(known: GaussianProcess, at: int) -> GaussianProcessRegressor:
    kernel = ConstantKernel(known.signal[at] ** 2) * RBF(known.lengths[at]) + WhiteKernel(
        known.noise[at] ** 2
    )
    other = GaussianProcessRegressor(kernel=kernel, optimizer=None, alpha=0.0)
    return other.fit(known.inputs, known.targets[:, at])


@pytest.mark.parametrize("at", [0, 1])
def test_predictions_are_those_of_scikit_learn(known: GaussianProcess, at: int) -> None:
    x = known.inputs[:20] + 0.3
    mean, variance = known.predict(x)
    theirs, spread = _second_library(known, at).predict(x, return_std=True)
    # Its spread is that of a noisy value. The condition number is near 60 * (45 / 0.3)^2 = 1e6,
    # so that 1e-16 * 1e6 of the signal are lost at most.
    assert mean[:, at] == pytest.approx(theirs, abs=1e-7 * known.signal[at])
    noisy = variance[:, at] + known.noise[at] ** 2
    assert noisy == pytest.approx(spread**2, abs=1e-7 * known.signal[at] ** 2)


def test_the_jacobian_is_the_slope_of_the_mean(known: GaussianProcess) -> None:
    x, step = known.inputs[:5] + 0.1, 1e-5
    slope = known.jacobian(x)
    for d in range(3):
        shift = step * np.eye(3)[d]
        there = (known.mean(x + shift) - known.mean(x - shift)) / (2.0 * step)
        # Centred differences err by step^2 / 6 = 2e-11 third derivatives (below 45 / 0.4^3).
        assert slope[:, :, d] == pytest.approx(there, abs=1e-6)


def test_the_evidence_and_its_gradient_are_those_of_scikit_learn(known: GaussianProcess) -> None:
    wide = Priors(length=(0.0, 1e6), signal=(0.0, 1e6), noise=(0.0, 1e6), clearest=1e6)
    x = (known.inputs - known.inputs.mean(axis=0)) / known.inputs.std(axis=0)
    logs = np.array([0.3, 0.6, -0.2, 0.1, -1.5])
    value, slope = Evidence(x, known.targets[:, 0], wide)(logs)
    kernel = ConstantKernel(np.exp(0.2)) * RBF(np.exp(logs[:3])) + WhiteKernel(np.exp(-3.0))
    other = GaussianProcessRegressor(kernel=kernel, optimizer=None, alpha=0.0)
    other.fit(x, known.targets[:, 0])
    theirs, their_slope = other.log_marginal_likelihood(kernel.theta, eval_gradient=True)
    # Ours adds 1e-8 of the signal's variance (1.2) to that of the noise (0.05): 2e-7 of it. Their
    # order is signal, lengths, noise, in logarithms of squares for the first and the last.
    assert value == pytest.approx(-theirs, abs=1e-4)
    order = np.array([2.0 * their_slope[0], *their_slope[1:4], 2.0 * their_slope[4]])
    assert slope == pytest.approx(-order[[1, 2, 3, 0, 4]], abs=1e-4)


def test_the_gradient_with_priors_is_a_finite_difference(known: GaussianProcess) -> None:
    x = (known.inputs - known.inputs.mean(axis=0)) / known.inputs.std(axis=0)
    problem = Evidence(x, known.targets[:, 0], Priors())
    # A signal of 300 noises: the steep part of the prior is felt.
    logs = np.array([0.3, 0.6, -0.2, 1.5, -4.3])
    _, slope = problem(logs)
    for at in range(5):
        shift = 1e-5 * np.eye(5)[at]
        there = (problem(logs + shift)[0] - problem(logs - shift)[0]) / 2e-5
        assert slope[at] == pytest.approx(there, rel=1e-5, abs=1e-5)


def test_a_fit_finds_the_settings_that_made_the_data() -> None:
    rng = np.random.default_rng(3)
    inputs = rng.uniform(-3.0, 3.0, size=(200, 2))
    made = GaussianProcess(
        inputs=inputs,
        targets=np.zeros((200, 1)),
        lengths=np.array([[1.0, 2.0]]),
        signal=np.array([2.0]),
        noise=np.array([0.1]),
    )
    targets = made.factor[0] @ rng.normal(size=(200, 1))
    found = fit(inputs, targets)
    # 200 values give the noise to 1 / sqrt(2 * 200) = 5 % of itself and lengths to some 10 %;
    # of the signal there are only some (6 / 1) (6 / 2) = 18 independent values: 20 %.
    assert found.noise == pytest.approx([0.1], rel=0.2)
    assert found.lengths == pytest.approx(np.array([[1.0, 2.0]]), rel=0.3)
    assert found.signal == pytest.approx([2.0], rel=0.6)


def test_a_warm_start_ends_where_a_cold_one_does() -> None:
    rng = np.random.default_rng(5)
    inputs = rng.uniform(-2.0, 2.0, size=(80, 1))
    targets = np.sin(3.0 * inputs) + 0.05 * rng.normal(size=inputs.shape)
    cold = fit(inputs, targets)
    warm = fit(inputs, targets, before=fit(inputs[:40], targets[:40]))
    # L-BFGS ends at a relative change of 2e-9 in the evidence: 1e-4 in a setting.
    assert warm.lengths == pytest.approx(cold.lengths, rel=1e-2)
    assert warm.noise == pytest.approx(cold.noise, rel=1e-2)


@pytest.mark.parametrize(
    "targets", [np.zeros(30), np.linspace(0.0, 1.0, 30), np.tile([0.0, 1e9], 15)]
)
def test_no_data_make_a_fit_fail(targets: np.ndarray) -> None:
    # The same input thirty times, without noise or with nothing else: the covariance is singular
    # but for the noise.
    found = fit(np.ones((30, 2)), targets[:, None])
    mean, variance = found.predict(np.ones((1, 2)))
    assert np.isfinite(mean).all()
    assert np.isfinite(variance).all()


def test_a_measurement_that_is_no_number_is_named() -> None:
    with pytest.raises(SearchError, match="no finite number"):
        fit(np.ones((10, 1)), np.full((10, 1), np.nan))
