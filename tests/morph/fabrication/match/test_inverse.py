"""Commands corrected by inverse dynamics."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.vary import vary
from morph.body.vary.heavier import Heavier
from morph.fabrication.match.case import Case
from morph.fabrication.match.inverse import RUNS, InverseMatcher, corrected
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy_transfer.retask import task_for
from morph.search.evaluate import attempt
from morph.task.hold import hold
from morph.task.tasks import task


def springs(robot: Robot, period: float) -> Linear:
    """Stiff enough that the arm neither falls nor meets the bounds of its motors."""
    gain = np.array([[-12.0, 0.0, -1.5, 0.0], [0.0, -2.0, 0.0, -0.3]])
    return Linear(
        weight=gain,
        bias=np.array([-12.9, -1.0]),
        action=actions_of(robot),
        observation=observations_of(robot),
        period=period,
    )


def test_a_body_of_half_the_density_is_told_half(arm: Callable[..., Robot]) -> None:
    # M a + h = u with M and h proportional to the density: u' = u / 2, without a shift.
    designed = arm()
    lighter = vary(designed, Heavier(link="*", factor=0.5))
    asked = hold(designed)
    policy = springs(designed, asked.period)
    case = Case(
        policy=policy,
        learned=policy,
        designed=asked,
        printed=task_for(asked, lighter),
        seconds=10.0,
    )
    assert InverseMatcher().suits(case)
    shifted, lawful = corrected(case)
    seen = 0.05 * np.random.default_rng(0).normal(size=(50, 4))
    told = policy.act(seen, np.zeros(50))
    # The ridge of 1e-3 draws slopes that the runs hardly tell apart towards 0: within 2 %.
    assert lawful.act(seen, np.zeros(50)) == pytest.approx(0.5 * told, rel=0.02, abs=0.02)
    # The shift is half of what is commanded at the ends of the runs, seen through noise.
    rng = np.random.default_rng([case.seed, 1])
    moved = attempt(asked, policy, case.drawing_board, rows=RUNS, rng=rng)
    assert shifted.bias == pytest.approx(-0.5 * moved.command[:, -1].mean(axis=0), abs=1e-6)


def test_a_cart_that_is_pushed_has_no_such_commands() -> None:
    robot = load("cartpole")
    asked = task("balance", robot)
    gain = np.zeros((1, 4))
    policy = Linear(
        weight=gain,
        bias=np.zeros(1),
        action=actions_of(robot),
        observation=observations_of(robot),
        period=asked.period,
    )
    case = Case(policy=policy, learned=policy, designed=asked, printed=asked, seconds=1.0)
    assert not InverseMatcher().suits(case)
