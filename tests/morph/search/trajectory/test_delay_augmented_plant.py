"""A body behind a line: its slopes are those of the simulation, and its commands come in time."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.actuator.actuator_lag import ActuatorLag
from morph.physics.effect import Effect
from morph.search.trajectory.delay_augmented_plant import DelayAugmentedPlant
from morph.sim.closed_loop import closed_loop
from morph.task.task import Task
from morph.task.tasks import task

PERIODS = 20


@pytest.fixture(scope="module")
def cartpole() -> Task:
    return task("swing-up", load("cartpole"))


@pytest.mark.parametrize(
    "effect", [ActuatorDelay(actuator="slide", T=0.033), ActuatorLag(actuator="slide", T=0.04)]
)
def test_it_moves_as_the_closed_loop_of_the_late_simulator_does(
    cartpole: Task, effect: Effect
) -> None:
    simulator = cartpole.simulator((effect,))
    line = DelayAugmentedPlant(simulator, cartpole.period, PERIODS)
    told = np.random.default_rng(3).uniform(-10.0, 10.0, (1, PERIODS, 1))
    given = line.arriving(told)
    q, v = np.zeros((1, 2)), np.zeros((1, 2))
    known = closed_loop(
        simulator,
        lambda q, v, time: told[:, round(time / cartpole.period)],
        q,
        v,
        period=cartpole.period,
        seconds=PERIODS * cartpole.period,
    )
    for at in range(PERIODS):
        q, v = line.through(q, v, given[:, at])
    np.testing.assert_allclose(q, known.position[:, -1], atol=1e-12)
    np.testing.assert_allclose(v, known.velocity[:, -1], atol=1e-12)


def test_its_slopes_foretell_a_small_change_of_one_command_many_periods_on(
    cartpole: Task,
) -> None:
    simulator = cartpole.simulator((ActuatorDelay(actuator="slide", T=0.033),))
    line = DelayAugmentedPlant(simulator, cartpole.period, PERIODS)
    told = np.random.default_rng(3).uniform(-8.0, 8.0, (2, PERIODS, 1))
    told[1] = told[0]
    small = 1e-4
    told[1, 4] += small
    given = line.arriving(told)
    q, v = np.zeros((2, PERIODS + 1, 2)), np.zeros((2, PERIODS + 1, 2))
    for at in range(PERIODS):
        q[:, at + 1], v[:, at + 1] = line.through(q[:, at], v[:, at], given[:, at])
    A, B, _ = line.linearised(q[:1, :-1], v[:1, :-1], given[:1])
    z = np.zeros(A.shape[-1])
    for at in range(PERIODS):
        z = A[0, at] @ z + B[0, at, :, 0] * (small if at == 4 else 0.0)
    moved = np.concatenate([q[1, -1] - q[0, -1], v[1, -1] - v[0, -1]])
    # What is left out is of second order: a millionth of the change, with a factor of slopes.
    np.testing.assert_allclose(z[:4], moved, rtol=2e-3, atol=1e-3 * np.abs(moved).max())


def test_commands_told_for_a_delay_of_one_period_are_those_wanted_one_period_on(
    cartpole: Task,
) -> None:
    line = DelayAugmentedPlant(
        cartpole.simulator((ActuatorDelay(actuator="slide", T=cartpole.period),)),
        cartpole.period,
        PERIODS,
    )
    wanted = np.random.default_rng(3).uniform(-8.0, 8.0, (1, PERIODS, 1))
    # What is held before the start is the first command too: it must serve two periods.
    wanted[:, 1] = wanted[:, 0]
    low, high = np.full(1, -10.0), np.full(1, 10.0)
    told = line.told(wanted, low, high)
    np.testing.assert_allclose(told[0, :-1], wanted[0, 1:], atol=1e-6)
