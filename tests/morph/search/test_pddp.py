from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.model.gp.gp import GaussianProcess
from morph.search.gp_rollout.plant import BeliefPlant, Beliefs, belief_plant
from morph.search.gp_rollout.task import view_of
from morph.search.pddp import begun, followed
from morph.search.trajectory.backward import backward
from morph.task.tasks import task


@pytest.fixture(scope="module")
def plant() -> BeliefPlant:
    """A made-up cart-pole: accelerations of command and gravity, known from 60 states."""
    asked = replace(task("swing-up", load("cartpole")), horizon=0.5)
    rng = np.random.default_rng(3)
    x = rng.normal(size=(60, 5)) * np.array([2.0, 4.0, 0.7, 0.7, 6.0])
    y = np.stack([0.05 * x[:, 4], -0.5 * x[:, 2] - 0.05 * x[:, 4] * x[:, 3]], axis=1)
    process = GaussianProcess(
        inputs=x,
        targets=y + 0.02 * rng.normal(size=y.shape),
        lengths=np.array([[5.0, 9.0, 2.0, 2.0, 12.0], [6.0, 8.0, 1.5, 1.2, 14.0]]),
        signal=np.array([0.5, 0.6]),
        noise=np.array([0.04, 0.05]),
    )
    return belief_plant(view_of(asked), process, 0.01)


@pytest.fixture(scope="module")
def beliefs(plant: BeliefPlant) -> Beliefs:
    rng = np.random.default_rng(4)
    found = begun(plant, rng.uniform(-8.0, 8.0, size=(10, 1)))
    return replace(found, gain=rng.normal(size=found.gain.shape))


def _after(plant: BeliefPlant, beliefs: Beliefs, at: int, b: Array, u: Array) -> Array:
    d, (rows, columns) = 4, plant.upper
    S = np.zeros((1, d, d))
    S[0, rows, columns], S[0, columns, rows] = b[d:], b[d:]
    return np.asarray(plant.vector(*plant.after(b[None, :d], S, u[None], beliefs.gain[:, at]))[0])


def test_the_slopes_of_a_belief_are_finite_differences(
    plant: BeliefPlant, beliefs: Beliefs
) -> None:
    A, B = plant.slopes(beliefs)
    for at in (0, 4, 9):
        b = plant.vector(beliefs.mean[0, at], beliefs.covariance[0, at])
        u, step = beliefs.command[0, at], 1e-4

        def moved(shift: Array, more: float, at: int = at, b: Array = b, u: Array = u) -> Array:
            return _after(plant, beliefs, at, b + shift, u + more)

        columns = [
            (moved(step * e, 0.0) - moved(-step * e, 0.0)) / (2.0 * step) for e in np.eye(len(b))
        ]
        # Differences err by step^2 = 1e-8 third derivatives (below 100), and by rounding.
        assert A[0, at] == pytest.approx(np.stack(columns, axis=1), abs=1e-5)
        none = np.zeros(len(b))
        slope = (moved(none, 1e-3) - moved(none, -1e-3)) / 2e-3
        assert B[0, at, :, 0] == pytest.approx(slope, abs=1e-6)


def test_a_cost_along_a_belief_has_the_slope_of_finite_differences(
    plant: BeliefPlant, beliefs: Beliefs
) -> None:
    found = plant.quadratic(beliefs)
    at, step = 6, 1e-5
    m, S, none = beliefs.mean[0, at], beliefs.covariance[0, at], np.zeros((1, 0, 1))
    for d in range(4):
        shift = step * np.eye(4)[d]
        there = plant.costs((m + shift)[None, None], S[None, None], none)
        back = plant.costs((m - shift)[None, None], S[None, None], none)
        assert found.x[0, at, d] == pytest.approx(float((there - back)[0]) / (2 * step), abs=1e-6)
    assert np.linalg.eigvalsh(found.xx[0]).min() > -1e-6 * np.abs(found.xx[0]).max()


def test_improving_a_belief_lowers_its_expected_cost(plant: BeliefPlant) -> None:
    now = begun(plant, np.zeros((10, 1)))
    low, high = np.array([-8.0]), np.array([8.0])
    before = float(now.cost[0])
    wide = plant.widened(4.0)
    A, B = plant.slopes(now)
    law = backward(
        A, B, wide.quadratic(now), low - now.command, high - now.command, np.ones((1, 1))
    )
    after = followed(wide, now, law, low, high)
    assert float(after.cost[0]) < before
    assert (np.abs(after.command) <= 8.0).all()


def test_a_gain_counts_as_far_as_bounds_let_it(plant: BeliefPlant) -> None:
    # A speed's deviation of 1 and a gain of 5: a command's of 5; within +-10 with erf(2 / sqrt 2).
    S, K = np.diag([0.0, 0.0, 1.0, 0.0])[None], np.array([[[0.0, 0.0, 5.0, 0.0]]])
    felt = plant.felt(S, K, np.array([[10.0]]))
    # The blur of 0.01 adds 1e-4 of a variance of 1.
    assert felt[0, 0] == pytest.approx(0.9545, abs=1e-4)
    assert plant.felt(S, K, np.zeros((1, 1)))[0, 0] == 0.0
