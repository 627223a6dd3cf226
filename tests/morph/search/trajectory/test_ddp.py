"""Dynamic programming finds what other ways to the same optimum find."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from morph.arrays import Array
from morph.body.load import load
from morph.search.plan.initial_trajectories import SeedInputs, costed
from morph.search.plan.terminal_controller import grounded
from morph.search.trajectory.backward import backward
from morph.search.trajectory.cost import Quadratic, TaskCost
from morph.search.trajectory.ddp import Trajectories, ddp
from morph.search.trajectory.plant import Plant
from morph.task.tasks import task


@pytest.fixture(scope="module")
def pendulum() -> SeedInputs:
    """A pendulum that is to swing up in 0.6 s, twelve periods."""
    swing = replace(task("swing-up", load("pendulum")), horizon=0.6)
    swing = replace(swing, goals=tuple(replace(goal, last=0.1) for goal in swing.goals))
    return grounded(swing, swing.simulator(), margin=0.0, rng=np.random.default_rng(0))


def run(ground: SeedInputs, command: Array) -> Trajectories:
    q, v = ground.plant.rollout(*ground.starts(len(command)), command)
    return costed(ground, q, v, command)


def test_without_bounds_the_gains_are_those_of_the_riccati_recursion() -> None:
    rng = np.random.default_rng(1)
    periods, n, m = 8, 3, 2
    A, B = rng.normal(size=(1, periods, n, n)), rng.normal(size=(1, periods, n, m))
    Q, R = np.diag([1.0, 2.0, 0.5]), np.diag([0.3, 1.0])
    cost = Quadratic(
        x=np.zeros((1, periods + 1, n)),
        u=np.zeros((1, periods + 1, m)),
        xx=np.tile(Q, (1, periods + 1, 1, 1)),
        uu=np.tile(R, (1, periods + 1, 1, 1)),
        ux=np.zeros((1, periods + 1, m, n)),
    )
    wide = np.full((1, periods, m), np.inf)
    law = backward(A, B, cost, -wide, wide, np.zeros((1, m)))
    P = Q
    for at in reversed(range(periods)):
        a, b = A[0, at], B[0, at]
        K = -np.linalg.inv(R + b.T @ P @ b) @ b.T @ P @ a
        assert law.gain[0, at] == pytest.approx(K, rel=1e-8)
        P = Q + a.T @ P @ (a + b @ K)
    assert not law.change.any()


def test_with_bounds_the_change_is_that_of_one_large_quadratic() -> None:
    # One integrator: x' = x + u from x = 5, cost sum of 1/2 (x^2 + 0.1 u^2), |u| <= 1. As a
    # quadratic in all commands at once it is solved by another method.
    periods = 6
    ones = np.ones((1, periods, 1, 1))
    low, high = -np.ones((1, periods, 1)), np.ones((1, periods, 1))
    command, x = np.zeros(periods), np.full(periods + 1, 5.0)
    for _ in range(10):
        cost = Quadratic(
            x=x[None, :, None],
            u=0.1 * np.append(command, 0.0)[None, :, None],
            xx=np.ones((1, periods + 1, 1, 1)),
            uu=np.full((1, periods + 1, 1, 1), 0.1),
            ux=np.zeros((1, periods + 1, 1, 1)),
        )
        told = command[None, :, None]
        law = backward(ones, ones, cost, low - told, high - told, np.zeros((1, 1)))
        new, at = np.empty(periods), 5.0
        for step in range(periods):
            wanted = (
                command[step] + law.change[0, step, 0] + law.gain[0, step, 0, 0] * (at - x[step])
            )
            new[step] = np.clip(wanted, -1.0, 1.0)
            at += new[step]
        command, x = new, 5.0 + np.append(0.0, np.cumsum(new))

    def total(u: Array) -> float:
        states = 5.0 + np.append(0.0, np.cumsum(u))
        return float(0.5 * np.sum(states**2) + 0.05 * np.sum(u**2))

    other = minimize(total, np.zeros(periods), bounds=[(-1.0, 1.0)] * periods, tol=1e-12)
    assert command == pytest.approx(other.x, abs=1e-5)


def test_the_slope_of_the_cost_is_that_of_its_values(pendulum: SeedInputs) -> None:
    rng = np.random.default_rng(4)
    periods = pendulum.periods
    q, v = rng.normal(size=(1, periods + 1, 1)), rng.normal(size=(1, periods + 1, 1))
    u = rng.normal(size=(1, periods, 1))
    found = pendulum.cost.quadratic(q, v, u)
    step = 1e-5
    for which, slope in ((q, found.x[0, :, 0]), (v, found.x[0, :, 1]), (u, found.u[0, :-1, 0])):
        for at in range(len(slope)):
            value = []
            for sign in (1.0, -1.0):
                which[0, at, 0] += sign * step
                value.append(pendulum.cost.values(q, v, u).sum())
                which[0, at, 0] -= sign * step
            # Differences of 1e-5 in sums of order 100: rounding of 1e-14 / 1e-5.
            assert slope[at] == pytest.approx((value[0] - value[1]) / (2.0 * step), abs=1e-5)


def test_the_quadratic_of_a_saturating_term_lies_above_it_along_its_error() -> None:
    # The tip of a pole that leans by p is 2 l sin(p / 2) from the top; all else is left out.
    swing = task("swing-up", load("pendulum"))
    # A goal that allows anything weighs nothing.
    swing = replace(swing, goals=(replace(swing.goals[0], within=1e9),))
    plant = Plant(swing.simulator(), swing.period)
    cost = TaskCost(
        task=swing,
        plant=plant,
        effort=0.0,
        rest=np.zeros(1),
        goal=(np.array([np.pi]), np.zeros(1)),
        beyond=np.zeros((2, 2)),
    )
    length, width = 1.0, 0.5
    v, u = np.zeros((1, 2, 1)), np.zeros((1, 1, 1))
    for lean in (0.05, 0.3, 0.6):
        q = np.full((1, 2, 1), np.pi + lean)
        found = cost.quadratic(q, v, u)
        away = 2.0 * length * np.sin(lean / 2.0)
        weight = np.exp(-0.5 * (away / width) ** 2)
        # |e|^2 / 2 has the Gauss-Newton curvature l^2 / w^2 in the angle.
        assert found.xx[0, 0, 0, 0] == pytest.approx(weight * (length / width) ** 2, rel=1e-6)
        assert found.xx[0, 0, 0, 0] > 0.0


def test_a_pendulum_swings_up_as_cheaply_as_by_a_search_over_all_commands(
    pendulum: SeedInputs,
) -> None:
    periods = pendulum.periods
    begun = run(pendulum, np.full((1, periods, 1), 8.0))
    found = ddp(pendulum.plant, pendulum.cost, begun, most=60, enough=1e-7)

    def total(u: Array) -> float:
        return float(run(pendulum, u.reshape(1, periods, 1)).cost[0])

    other = minimize(
        total, found.command.ravel(), bounds=[(-10.0, 10.0)] * periods, method="L-BFGS-B"
    )
    assert found.cost[0] < 0.5 * begun.cost[0]
    # What a second search that begins there can still gain is a thousandth.
    assert found.cost[0] <= other.fun * 1.001


def test_every_row_leaves_the_margin_that_it_is_told_and_none_gets_dearer(
    pendulum: SeedInputs,
) -> None:
    rng = np.random.default_rng(0)
    begun = run(pendulum, rng.uniform(-5.0, 5.0, (3, pendulum.periods, 1)))
    margin = np.array([0.0, 0.2, 0.5])
    found = ddp(pendulum.plant, pendulum.cost, begun, margin=margin, most=15)
    assert (found.cost <= begun.cost).all()
    assert (np.abs(found.command).max((1, 2)) <= 10.0 * (1.0 - margin) + 1e-9).all()
    again = run(pendulum, found.command)
    assert again.position == pytest.approx(found.position, abs=1e-9)
    assert again.cost == pytest.approx(found.cost)
