from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.model.missing_force.fourier_features import OWN, FourierFeatures, waves_of


@pytest.fixture
def waves() -> FourierFeatures:
    states = np.random.default_rng(0).normal(size=(200, 4)) * np.array([1.0, 2.0, 0.5, 3.0])
    found = waves_of(["slide", "hinge"], states, slides=False)
    return found.with_lengths(0.8, 1.5)


def test_the_covariance_of_own_velocity_is_exponential(waves: FourierFeatures) -> None:
    states = np.zeros((50, 4))
    states[:, 3] = np.linspace(0.0, 2.0, 50) * waves.size[1]
    rough = waves.of(states)[:, 1, : 2 * OWN]
    covariance = rough @ rough[0]
    far = np.linspace(0.0, 2.0, 50) / 0.8
    # The shares of Cauchy's distribution beyond 20 and between 16 and 20 are 0.032 and 0.008; each
    # interval's wave may be off by twice its share at most, and the two outermost are so at once.
    assert covariance == pytest.approx(np.exp(-far), abs=0.08)
    assert covariance[0] == pytest.approx(1.0)


def test_the_covariance_of_the_whole_is_a_squared_exponential_on_average(
    waves: FourierFeatures,
) -> None:
    states = np.random.default_rng(1).normal(size=(2, 4))
    products = []
    for seed in range(400):
        drawn = replace(waves, seed=seed)
        shared = drawn.of(states)[:, 0, drawn.own :]
        products.append(float(shared[0] @ shared[1]))
    looked = np.column_stack(
        [np.cos(states[:, 1]), np.sin(states[:, 1]), states[:, 2:] / waves.size]
    )
    exact = np.exp(-0.5 * ((looked[0] - looked[1]) ** 2).sum() / 1.5**2)
    # Of 400 * 32 cosines, each of variance below 1/2: 0.0063 is a standard deviation, 4 of it.
    assert np.mean(products) == pytest.approx(exact, abs=0.025)


def test_a_full_turn_of_a_hinge_and_a_moved_slide_change_nothing(waves: FourierFeatures) -> None:
    state = np.array([0.3, 0.7, 0.2, -1.0])
    moved = state + np.array([5.0, 2.0 * np.pi, 0.0, 0.0])
    assert waves.of(moved) == pytest.approx(waves.of(state), abs=1e-12)


def test_where_a_slide_is_matters_if_it_was_said_to() -> None:
    states = np.random.default_rng(0).normal(size=(50, 4))
    waves = waves_of(["slide", "hinge"], states, slides=True)
    moved = states[0] + np.array([1.0, 0.0, 0.0, 0.0])
    assert np.abs(waves.of(moved) - waves.of(states[0])).max() > 0.05
