from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest

from morph.model.gp.gp import GaussianProcess
from morph.search.moments.moment_matching_rff import Lift, Squash
from morph.search.moments.moments import ProcessMoments
from morph.search.moments.radial import RadialNumbers, radial_forward
from morph.search.moments.saturating import ExpectedCost

SAMPLES = 1_000_000


def _process(n: int = 30, d: int = 4, e: int = 2) -> GaussianProcess:
    rng = np.random.default_rng(1)
    x = rng.normal(size=(n, d))
    y = np.stack([np.sin(x[:, 0]) + x[:, 1] * x[:, 2], x[:, 3] + np.cos(x[:, 1])], axis=1)[:, :e]
    return GaussianProcess(
        inputs=x,
        targets=y + 0.05 * rng.normal(size=y.shape),
        lengths=rng.uniform(1.0, 2.5, size=(e, d)),
        signal=np.array([1.5, 1.2])[:e],
        noise=np.full(e, 0.08),
    )


def _input(d: int, scale: float = 0.4) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(2)
    root = scale * rng.normal(size=(d, d))
    return 0.5 * rng.normal(size=d), root @ root.T + 0.01 * np.eye(d)


def test_moments_are_within_one_percent_of_a_million_samples() -> None:
    process, (m, S) = _process(), _input(4)
    found, _ = ProcessMoments(process).forward(m, S)
    rng = np.random.default_rng(3)
    count, total = 0, 0
    mean, outer, own, cross = np.zeros(2), np.zeros((2, 2)), np.zeros(2), np.zeros((4, 2))
    for _ in range(20):
        x = rng.multivariate_normal(m, S, size=SAMPLES // 20)
        y, variance = process.predict(x)
        count, total = count + len(x), total + 1
        mean, own = mean + y.mean(axis=0), own + variance.mean(axis=0)
        outer, cross = outer + y.T @ y / len(x), cross + (x - m).T @ y / len(x)
    mean, outer, own, cross = (each / total for each in (mean, outer, own, cross))
    covariance = outer - np.outer(mean, mean) + np.diag(own)
    assert count == SAMPLES
    # A mean of 10^6 samples errs by sd / 1000, a variance by 1.4e-3 of itself (of a normal).
    deviation = np.sqrt(np.diag(covariance))
    assert np.abs(found.mean - mean).max() < 0.004 * deviation.max()
    assert np.diag(found.covariance) == pytest.approx(np.diag(covariance), rel=0.01)
    assert found.covariance[0, 1] == pytest.approx(covariance[0, 1], abs=0.01 * deviation.prod())
    size = np.sqrt(np.diag(S))[:, None] * deviation
    assert np.abs(S @ found.slope.T - cross).max() < 0.01 * size.max()


def test_one_point_in_one_dimension_has_the_published_closed_form() -> None:
    # One basis function exp(-x^2 / 2) of x ~ N(m, v): its mean is (1 + v)^-1/2
    # exp(-m^2 / (2 (1 + v))), its square is exp(-x^2): (1 + 2 v)^-1/2 exp(-m^2 / (1 + 2 v)).
    m, v = 0.7, 0.3
    numbers = RadialNumbers(np.zeros((1, 1)), np.zeros(1), np.ones((1, 1)))
    found, _ = radial_forward(numbers, np.array([m]), np.array([[v]]))
    mean = math.exp(-(m**2) / (2.0 * (1.0 + v))) / math.sqrt(1.0 + v)
    square = math.exp(-(m**2) / (1.0 + 2.0 * v)) / math.sqrt(1.0 + 2.0 * v)
    assert found.mean[0] == pytest.approx(mean, rel=1e-12)
    assert found.covariance[0, 0] == pytest.approx(square - mean**2, rel=1e-9)
    # Stein: cov(x, f) = v E[f'], and dE/dm = -m / (1 + v) E.
    assert found.slope[0, 0] == pytest.approx(-m / (1.0 + v) * mean, rel=1e-12)


def test_a_certain_input_gives_the_prediction_and_its_slope() -> None:
    process, (m, _) = _process(), _input(4)
    found, _ = ProcessMoments(process).forward(m, np.zeros((4, 4)))
    mean, variance = process.predict(m[None])
    assert found.mean == pytest.approx(mean[0], rel=1e-9)
    assert found.slope == pytest.approx(process.jacobian(m[None])[0], rel=1e-9)
    # Differences of squares of 1.5 with a condition number near 30 (1.5 / 0.08)^2 = 1e4.
    assert found.covariance == pytest.approx(np.diag(variance[0]), abs=1e-9)


def test_radial_functions_are_a_certain_process() -> None:
    process, (m, S) = _process(e=1), _input(4)
    numbers = RadialNumbers(
        process.inputs,
        np.log(process.lengths[0]),
        process.weights * process.signal[:, None] ** 2,
    )
    mine, _ = radial_forward(numbers, m, S)
    theirs, _ = ProcessMoments(process, certain=True).forward(m, S)
    for name in mine._fields:
        assert getattr(mine, name) == pytest.approx(getattr(theirs, name), rel=1e-8, abs=1e-9)


def test_many_inputs_at_once_are_as_one_by_one() -> None:
    moments, rng = ProcessMoments(_process()), np.random.default_rng(4)
    m, (_, S) = rng.normal(size=(3, 4)), _input(4)
    many, _ = moments.forward(m, np.stack([S, 2.0 * S, 0.5 * S]))
    for at, scale in enumerate((1.0, 2.0, 0.5)):
        one, _ = moments.forward(m[at], scale * S)
        assert many.covariance[at] == pytest.approx(one.covariance, rel=1e-9)


def test_sines_and_cosines_have_the_moments_of_samples() -> None:
    lift = Lift(np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 1.0]]))
    m, S = _input(3, scale=0.6)
    mean, covariance, _ = lift.forward(m, S)
    x = np.random.default_rng(5).multivariate_normal(m, S, size=SAMPLES)
    angle = x @ lift.angles.T
    z = np.concatenate([x, np.sin(angle), np.cos(angle)], axis=1)
    # Standard errors: 1e-3 of a deviation (below 1.3) and of products of two of them.
    assert np.abs(mean - z.mean(axis=0)).max() < 5e-3
    assert np.abs(covariance - np.cov(z.T)).max() < 1e-2


def test_squashed_commands_have_the_moments_of_samples() -> None:
    low, high = np.array([-10.0, -1.0]), np.array([10.0, 3.0])
    m, S = _input(2, scale=0.7)
    mean, covariance, gain, _ = Squash(low, high).forward(m, S)
    r = np.random.default_rng(6).multivariate_normal(m, S, size=SAMPLES)
    u = 0.5 * (low + high) + 0.5 * (high - low) * (9.0 * np.sin(r) + np.sin(3.0 * r)) / 8.0
    # In halves of the range: standard errors of 1e-3.
    half = 0.5 * (high - low)
    assert np.abs((mean - u.mean(axis=0)) / half).max() < 5e-3
    assert np.abs((covariance - np.cov(u.T)) / np.outer(half, half)).max() < 5e-3
    crossed = np.cov(r.T, u.T)[:2, 2:]
    assert np.abs((S * gain - crossed) / half).max() < 5e-3


@pytest.mark.parametrize("norm", ["saturating", "quadratic"])
def test_an_expected_cost_is_the_mean_of_samples(norm: Literal["saturating", "quadratic"]) -> None:
    rng = np.random.default_rng(7)
    cost = ExpectedCost(A=rng.normal(size=(2, 3)), b=rng.normal(size=2), weight=2.0, norm=norm)
    m, S = _input(3)
    value, _, _ = cost.value(m, S)
    x = rng.multivariate_normal(m, S, size=SAMPLES)
    half = 0.5 * np.square(x @ cost.A.T + cost.b).sum(axis=1)
    sampled = 2.0 * (half if norm == "quadratic" else 1.0 - np.exp(-half))
    assert value == pytest.approx(sampled.mean(), abs=5.0 * sampled.std() / 1000.0)
