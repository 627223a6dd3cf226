"""A body as arrays about its rest does what the same body does in its simulation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from morph.body.load import load
from morph.policy_transfer.body import Body, body, linear_law, still_law
from morph.task.balance import balance
from morph.task.push import Push
from morph.task.upright import LEAN, STRAY


@pytest.fixture(scope="module")
def cart_pole() -> Body:
    return body(balance(load("cartpole")))


def test_the_slopes_of_a_cart_pole_are_those_of_its_equations(cart_pole: Body) -> None:
    # Upright, theta the lean towards +x and I = m l^2 / 12:
    # (M + m) x'' + m l / 2 theta'' = u - b x',
    # m l / 2 x'' + (m l^2 / 4 + I) theta'' = m g l / 2 theta.
    g, length, m, M, b = 9.82, 0.5, 0.5, 0.5, 0.1
    half = length / 2.0
    mass = np.array([[M + m, m * half], [m * half, m * half**2 + m * length**2 / 12.0]])
    force = np.array([[0.0, 0.0, -b, 0.0], [0.0, m * g * half, 0.0, 0.0]])
    A = np.zeros((4, 4))
    A[:2, 2:] = np.eye(2)
    A[2:] = np.linalg.solve(mass, force)
    expected = np.abs(np.linalg.eigvals(expm(0.02 * A)))
    found, _ = cart_pole.linear
    # RK4 at 10 ms leaves (0.01 * 7.7)^5 / 120 = 2e-8 a step.
    assert np.sort(np.abs(np.linalg.eigvals(found))) == pytest.approx(np.sort(expected), abs=1e-6)


def test_what_the_task_looks_at_is_tilt_and_place(cart_pole: Body) -> None:
    C = cart_pole.outcome
    # A hinge that turns by 1 rad tilts the centre of mass by 1 rad, 1 / LEAN of the score's unit.
    assert np.abs(C[0]) == pytest.approx([0.0, 1.0 / LEAN, 0.0, 0.0], abs=1e-4)
    assert np.abs(C[1]) == pytest.approx([1.0 / STRAY, 0.0, 0.0, 0.0], abs=1e-4)
    assert C[2, 2:] == pytest.approx(0.2 * C[0, :2], abs=1e-9)


def test_transitions_are_steps_of_the_body_where_nothing_is_noisy(cart_pole: Body) -> None:
    seen = cart_pole.transitions(40, np.random.default_rng(3), noise=0.0)
    again = cart_pole.step(seen.state, seen.command)
    assert again == pytest.approx(seen.after, abs=1e-12)
    assert (np.abs(seen.command) <= 10.0).all()


def test_a_reading_that_ends_one_transition_begins_the_next(cart_pole: Body) -> None:
    seen = cart_pole.transitions(40, np.random.default_rng(3))
    shared = (seen.state[1:] == seen.after[:-1]).all(axis=1)
    # A run ends once the pole has tilted by a quarter of a radian: most transitions go on.
    assert shared.mean() > 0.7
    # 0.01 of noise in 320 numbers: the spread of their spread is 0.01 / sqrt(640) = 4e-4.
    clean = cart_pole.transitions(40, np.random.default_rng(3), noise=0.0)
    assert (seen.after - clean.after).std() == pytest.approx(0.01, abs=1.6e-3)


def test_holding_still_falls_and_a_regulator_does_not(cart_pole: Body) -> None:
    start = replace(cart_pole.task.start, push=Push(link="pole", impulse=(0.2, 0.0, 0.0)))
    pushed = replace(cart_pole, task=replace(cart_pole.task, start=start))
    gain = np.array([[3.0, 40.0, 4.0, 8.0]])
    A, B = pushed.linear
    sign = min(
        (gain * np.array([a, c, a, c]) for a in (1.0, -1.0) for c in (1.0, -1.0)),
        key=lambda each: np.abs(np.linalg.eigvals(A + B @ each)).max(),
    )
    assert pushed.score(linear_law(sign)) > 0.95
    assert pushed.score(still_law(1)) < 0.3
    assert pushed.score(linear_law(-sign)) < 0.3
