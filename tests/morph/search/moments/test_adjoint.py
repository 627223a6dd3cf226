from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.model.gp.gp import GaussianProcess
from morph.search.gp_rollout.belief import GPPlant
from morph.search.gp_rollout.laws import LinearLaw, RadialLaw
from morph.search.gp_rollout.rollout import imagine
from morph.search.moments.moment_matching_rff import Lift, Squash
from morph.search.moments.moments import ProcessMoments
from morph.search.moments.radial import RadialNumbers, radial_backward, radial_forward
from morph.search.moments.saturating import ExpectedCost

RNG = np.random.default_rng(11)
TIP = ExpectedCost(
    A=np.array([[1.0, 0.0, 0.0, 0.0, 0.5, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, -0.5]]) / 0.25,
    b=np.array([0.0, -2.0]),
)


def _slope(f: Callable[[np.ndarray], float], x: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Return the derivative of f by centred differences of the fourth order."""
    found = np.zeros_like(x)
    for at in np.ndindex(x.shape):
        shift = np.zeros_like(x)
        shift[at] = step
        near, far = f(x + shift) - f(x - shift), f(x + 2.0 * shift) - f(x - 2.0 * shift)
        found[at] = (8.0 * near - far) / (12.0 * step)
    return found


def _close(mine: np.ndarray, theirs: np.ndarray) -> None:
    # Values near 1 err by 1e-16 times some hundred operations with weights near 100: 1e-11
    # at most, over a step of 1e-4 1e-7. The differences' own error is of the order of step^4.
    assert np.abs(mine - theirs).max() < 1e-5 * np.abs(theirs).max()


def _even(S: np.ndarray) -> np.ndarray:
    return np.asarray(0.5 * (S + S.T))


def _covariance(d: int, scale: float = 0.3) -> np.ndarray:
    root = scale * np.random.default_rng(d).normal(size=(d, d))
    return np.asarray(root @ root.T + 0.01 * np.eye(d))


def _process(d: int) -> GaussianProcess:
    rng = np.random.default_rng(12)
    x = rng.normal(size=(40, d)) * np.array([2.0, 4.0, 0.7, 0.7, 6.0])[:d]
    y = np.stack([0.05 * x[:, -1], -0.5 * x[:, 2] - 0.05 * x[:, -1] * x[:, 3]], axis=1)
    return GaussianProcess(
        inputs=x,
        targets=y + 0.02 * rng.normal(size=y.shape),
        lengths=np.array([[5.0, 9.0, 2.0, 2.0, 12.0], [6.0, 8.0, 1.5, 1.2, 14.0]])[:, :d],
        signal=np.array([0.5, 0.6]),
        noise=np.array([0.04, 0.05]),
    )


def test_the_adjoint_of_a_process_is_a_finite_difference() -> None:
    moments, m, S = ProcessMoments(_process(5)), 0.5 * RNG.normal(size=5), _covariance(5)
    a, b, c = RNG.normal(size=2), RNG.normal(size=(2, 2)), RNG.normal(size=(2, 5))

    def told(m: np.ndarray, S: np.ndarray) -> float:
        out, _ = moments.forward(m, _even(S))
        return float((out.mean * a).sum() + (out.covariance * b).sum() + (out.slope * c).sum())

    _, tape = moments.forward(m, S)
    into_m, into_S = moments.backward(tape, a, b, c)
    _close(into_m, _slope(lambda x: told(x, S), m, 1e-3))
    _close(into_S, _slope(lambda x: told(m, x), S, 1e-3))


def test_the_adjoint_of_radial_functions_is_a_finite_difference() -> None:
    numbers = RadialNumbers(
        RNG.normal(size=(6, 3)), 0.2 * RNG.normal(size=3), RNG.normal(size=(2, 6))
    )
    m, S = 0.5 * RNG.normal(size=3), _covariance(3)
    a, b, c = RNG.normal(size=2), RNG.normal(size=(2, 2)), RNG.normal(size=(2, 3))

    def told(numbers: RadialNumbers, m: np.ndarray, S: np.ndarray) -> float:
        out, _ = radial_forward(numbers, m, _even(S))
        return float((out.mean * a).sum() + (out.covariance * b).sum() + (out.slope * c).sum())

    _, tape = radial_forward(numbers, m, S)
    into_m, into_S, into = radial_backward(tape, a, b, c)
    _close(into_m, _slope(lambda x: told(numbers, x, S), m, 1e-3))
    _close(into_S, _slope(lambda x: told(numbers, m, x), S, 1e-3))
    for name in numbers._fields:

        def other(x: np.ndarray, name: str = name) -> float:
            return told(numbers._replace(**{name: x}), m, S)

        _close(getattr(into, name), _slope(other, getattr(numbers, name), 1e-3))


def test_the_adjoint_of_sines_and_cosines_is_a_finite_difference() -> None:
    lift, m, S = (
        Lift(np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 1.0]])),
        RNG.normal(size=3),
        _covariance(3),
    )
    a, b = RNG.normal(size=7), _even(RNG.normal(size=(7, 7)))

    def told(m: np.ndarray, S: np.ndarray) -> float:
        mean, covariance, _ = lift.forward(m, _even(S))
        return float((mean * a).sum() + (covariance * b).sum())

    _, _, tape = lift.forward(m, S)
    into_m, into_S = lift.backward(tape, a, b)
    _close(into_m, _slope(lambda x: told(x, S), m, 1e-3))
    _close(into_S, _slope(lambda x: told(m, x), S, 1e-3))


def _plant() -> GPPlant:
    return GPPlant(
        process=ProcessMoments(_process(5)),
        looks=np.array([2, 3, 4, 5, 6]),
        sees=np.array([0, 2, 3, 4, 5]),
        lift=Lift(np.array([[0.0, 1.0, 0.0, 0.0]])),
        squash=Squash(np.array([-10.0]), np.array([10.0])),
        noise=np.full(2, 1e-4),
        blur=np.full(5, 1e-4),
        period=0.05,
    )


RADIAL = RadialNumbers(
    RNG.normal(size=(8, 5)), np.log([1.0, 2.0, 4.0, 1.0, 1.0]), 0.5 * RNG.normal(size=(1, 8))
)


@pytest.mark.parametrize("part", ["centre", "width", "weight"])
def test_the_gradient_of_an_expected_loss_is_a_finite_difference(part: str) -> None:
    plant, periods = _plant(), 8
    m, S = np.array([0.1, 2.0, 0.3, 1.0]), 0.01 * np.eye(4)

    def loss(x: np.ndarray) -> float:
        law = RadialLaw(RADIAL._replace(**{part: x}))
        return float(imagine(plant, law, (TIP,), m, S, periods).loss)

    gradient = imagine(plant, RadialLaw(RADIAL), (TIP,), m, S, periods).gradient
    cuts = {"centre": slice(0, 40), "width": slice(40, 45), "weight": slice(45, 53)}
    theirs = _slope(loss, getattr(RADIAL, part), 1e-3).ravel()
    _close(gradient[cuts[part]], theirs)


def test_the_gradient_of_a_linear_law_is_a_finite_difference() -> None:
    plant, m, S = _plant(), np.array([0.1, 2.0, 0.3, 1.0]), 0.01 * np.eye(4)
    numbers = 0.2 * RNG.normal(size=6)

    def loss(x: np.ndarray) -> float:
        return float(imagine(plant, LinearLaw(x[None, :5], x[5:]), (TIP,), m, S, 8).loss)

    law = LinearLaw(numbers[None, :5], numbers[5:])
    gradient = imagine(plant, law, (TIP,), m, S, 8).gradient
    _close(gradient, _slope(loss, numbers, 1e-3))


def test_one_step_has_the_moments_of_samples() -> None:
    plant, process = _plant(), _process(5)
    m, S = np.array([0.1, 2.0, 0.3, 1.0]), 0.02 * np.eye(4)
    mean, covariance, _ = plant.forward(m, S, RadialLaw(RADIAL))
    rng, count = np.random.default_rng(13), 200_000
    x = rng.multivariate_normal(m, S, size=count)
    # What is seen is blurred; the features are those of the state, with noise of 0.01 each.
    z = np.concatenate([x, np.sin(x[:, 1:2]), np.cos(x[:, 1:2])], axis=1)
    seen = z[:, plant.sees] + 0.01 * rng.normal(size=(count, 5))
    away = (seen[:, None] - RADIAL.centre) / np.exp(RADIAL.width)
    r = np.exp(-0.5 * np.square(away).sum(axis=-1)) @ RADIAL.weight.T
    u = 10.0 * (9.0 * np.sin(r) + np.sin(3.0 * r)) / 8.0
    inputs = np.concatenate([z, u], axis=1)[:, plant.looks]
    change, variance = process.predict(inputs)
    change = change + np.sqrt(variance + 1e-4) * rng.normal(size=change.shape)
    v = x[:, 2:] + change
    after = np.concatenate([x[:, :2] + 0.025 * (x[:, 2:] + v), v], axis=1)
    # (x, sin, cos, u) is taken to be Gaussian three times on the way, which it is not: with an
    # angle's deviation of 0.14 rad that costs some percent of the spread of the velocity.
    deviation = np.sqrt(np.diag(covariance))
    assert np.abs((mean - after.mean(axis=0)) / deviation).max() < 0.03
    assert np.abs((covariance - np.cov(after.T)) / np.outer(deviation, deviation)).max() < 0.03
