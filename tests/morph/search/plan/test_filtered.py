"""Feedback from what was seen of late: without doubt a regulator, with it a Kalman filter."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from morph.body.load import load
from morph.search.plan.filtered import along, filtered, gains
from morph.search.plan.initial_trajectories import SeedInputs, costed
from morph.search.plan.terminal_controller import grounded
from morph.search.trajectory.ddp import Trajectories
from morph.task.tasks import task


@pytest.fixture(scope="module")
def ground() -> SeedInputs:
    wanted = task("swing-up", load("cartpole"))
    return grounded(wanted, wanted.simulator(), margin=0.0, rng=np.random.default_rng(0))


@pytest.fixture(scope="module")
def upright(ground: SeedInputs) -> Trajectories:
    samples = ground.periods + 1
    q = np.tile(ground.still.position, (1, samples, 1))
    return costed(ground, q, np.zeros_like(q), np.zeros((1, samples - 1, 1)))


def test_without_a_filter_only_the_newest_sample_counts_and_rest_has_the_regulators_gain(
    ground: SeedInputs, upright: Trajectories
) -> None:
    found = filtered(ground, along(ground, upright), 1.0, np.inf, ages=5)
    assert not found[..., 1:, :].any()
    # The regulator discounts by 0.999 a period, and the plan does not.
    np.testing.assert_allclose(found[0, -1, :, 0], ground.regulator.gain, rtol=0.02)


def test_at_rest_it_is_the_kalman_filter_of_the_riccati_equation(
    ground: SeedInputs, upright: Trajectories
) -> None:
    near = along(ground, upright)
    doubt, noise = 0.1, ground.cost.task.noise
    found = filtered(ground, near, 3.0, doubt, ages=8)[0, -1]
    A, B = near.A[0, -1], near.B[0, -1]
    pushed = B * doubt * 10.0
    P = solve_discrete_are(A.T, np.eye(4), pushed @ pushed.T, noise**2 * np.eye(4))
    L = P @ np.linalg.inv(P + noise**2 * np.eye(4))
    K = gains(near, 3.0)[0, ground.periods // 2]
    Z = L
    for age in range(8):
        np.testing.assert_allclose(found[:, age], K @ Z, rtol=0.02, atol=0.02)
        Z = (np.eye(4) - L) @ (A + B @ K) @ Z
