"""A plan that begins from an old policy serves a changed body, also one that is late."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import SearchError
from morph.physics.actuator.actuator_delay import ActuatorDelay
from morph.physics.joint.viscous_friction import ViscousFriction
from morph.policy.policy import Policy
from morph.search.ddp import Plan
from morph.search.evaluate import evaluate
from morph.search.plan.delayed_actuation import late as again_late
from morph.search.plan.replan import STAGES, again
from morph.search.plan.warm_start import stretched
from morph.search.search import Problem
from morph.sim.simulator import Simulator
from morph.task.task import Task
from morph.task.tasks import task


@pytest.fixture(scope="module")
def cartpole() -> Task:
    return task("swing-up", load("cartpole"))


@pytest.fixture(scope="module")
def old(cartpole: Task) -> Policy:
    problem = Problem(task=cartpole, simulator=cartpole.simulator())
    return Plan(rows=256, keep=2, most=10, rounds=1).run(problem, seed=100).policy


def share(task: Task, policy: Policy, simulator: Simulator) -> float:
    return evaluate(task, policy, simulator, rng=np.random.default_rng(7), rows=60).share


def test_commands_take_twice_as_long_and_give_the_same_push_a_second() -> None:
    command = np.array([[2.0], [-4.0], [1.0]])
    found = stretched(command, 2.0, 8)[:, 0]
    # Each push serves two periods, and the last is held on.
    np.testing.assert_allclose(found, [2.0, 2.0, -4.0, -4.0, 1.0, 1.0, 1.0, 1.0])


def test_where_the_old_policy_fails_under_friction_one_small_stage_serves(
    cartpole: Task, old: Policy
) -> None:
    rough = cartpole.simulator((ViscousFriction(joint="slide", b=1.0),))
    learned = again(cartpole, rough, old, seed=101, stages=STAGES[:2])
    assert share(cartpole, old, rough) < 0.5
    assert share(cartpole, learned.policy, rough) >= 0.9


def test_a_plan_led_in_time_swings_up_where_a_delay_fails_one_that_ignores_it(
    cartpole: Task, old: Policy
) -> None:
    # Two thirds of a control period: no shift of whole periods would do.
    late = cartpole.simulator((ActuatorDelay(actuator="slide", T=0.033),))
    learned = again_late(cartpole, late, old, seed=101, tries=((64, 0.0),))
    assert share(cartpole, old, late) < 0.5
    assert share(cartpole, learned.policy, late) >= 0.9


def test_without_an_old_policy_and_without_fresh_swings_it_says_that_there_is_nothing(
    cartpole: Task,
) -> None:
    with pytest.raises(SearchError, match="no stage to search in"):
        again(
            cartpole,
            cartpole.simulator(),
            None,
            seed=101,
            stages=(replace(STAGES[0], rows=0),),
        )
