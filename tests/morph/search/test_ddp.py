"""Plans swing bodies up, are chosen by how they do in the noise, and say so if they fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import SearchError
from morph.policy.linear import Linear
from morph.search.ddp import Plan
from morph.search.evaluate import attempt, evaluate
from morph.search.lqr import Lqr
from morph.search.plan.initial_trajectories import led, swung
from morph.search.plan.terminal_controller import grounded
from morph.search.receding import Receding
from morph.search.search import Learned, Problem, State, Trial
from morph.task.task import Task
from morph.task.tasks import task


def problem(wanted: Task) -> Problem:
    return Problem(task=wanted, simulator=wanted.simulator())


@pytest.fixture(scope="module")
def cartpole() -> Task:
    return task("swing-up", load("cartpole"))


@pytest.fixture(scope="module")
def learned(cartpole: Task) -> Learned:
    return Plan().run(problem(cartpole), seed=100)


def test_the_cartpole_swings_up_from_other_starts_and_in_finer_steps(
    cartpole: Task, learned: Learned
) -> None:
    assert learned.succeeded
    assert not learned.why
    finer = replace(cartpole, step=0.001)
    rng = np.random.default_rng(7)
    score = evaluate(finer, learned.policy, finer.simulator(), rng=rng, rows=40)
    assert score.share >= 0.95
    # Searched bang-bang swings with a regulator at the top cost 14.45, without noise.
    assert np.median(score.loss) < 14.45


def test_long_after_the_plan_has_ended_the_pole_still_stands(
    cartpole: Task, learned: Learned
) -> None:
    longer = replace(cartpole, horizon=10.0)
    rng = np.random.default_rng(7)
    moved = attempt(longer, learned.policy, longer.simulator(), rows=20, rng=rng)
    assert longer.succeeded(moved).all()


def test_a_search_that_draws_too_little_says_that_it_failed_and_gives_its_best(
    cartpole: Task,
) -> None:
    found = Plan(rows=16, keep=1, most=1).run(problem(cartpole), seed=101, trials=1)
    assert not found.succeeded
    assert "reaches every goal in" in found.why
    assert found.policy.kind == "track"


def test_a_search_that_goes_on_from_what_it_kept_ends_as_one_that_was_not_stopped() -> None:
    wanted = replace(task("swing-up", load("pendulum")), horizon=1.0)
    kept: list[State] = []
    search = Plan(rows=32, keep=1, most=2, runs=4, target=1e-3)

    def told(trial: Trial, state: State) -> None:
        kept.append(state)

    whole = search.run(problem(wanted), seed=100, trials=2, progress=told)
    rest = search.run(problem(wanted), seed=100, trials=2, state=kept[0])
    assert [trial.number for trial in whole.trials] == [1, 2]
    assert [trial.number for trial in rest.trials] == [2]
    ends = [found.policy.weights() for found in (whole, rest)]
    for name, value in ends[0].items():
        assert np.array_equal(value, ends[1][name])
    with pytest.raises(SearchError, match="lacks a plan"):
        search.run(problem(wanted), seed=100, state={"round": np.array(1.0)})


def test_a_search_that_was_content_when_it_was_killed_makes_no_further_round() -> None:
    wanted = task("swing-up", load("pendulum"))
    kept: list[State] = []
    search = Plan(rows=64, keep=2, most=8, runs=4)
    whole = search.run(problem(wanted), seed=100, progress=lambda _, state: kept.append(state))
    assert len(whole.trials) < search.rounds
    rest = search.run(problem(wanted), seed=100, state=kept[-1])
    assert rest.trials == ()
    assert rest.policy == whole.policy


def test_guesses_stay_within_their_margin(cartpole: Task) -> None:
    rng = np.random.default_rng(100)
    ground = grounded(cartpole, cartpole.simulator(), margin=0.25, rng=rng)
    assert np.abs(swung(ground, 64, 4, rng).command).max() <= 7.5 + 1e-9


def test_along_a_straight_path_a_driven_chain_ends_where_it_should() -> None:
    wanted = task("swing-up", load("double_pendulum"))
    rng = np.random.default_rng(0)
    ground = grounded(wanted, wanted.simulator(), margin=0.0, rng=rng)
    run = led(ground, 1)
    moved = ground.cost.moved(run.position, run.velocity, run.command)
    assert wanted.succeeded(moved).all()


@pytest.mark.parametrize("name", ["rider_two_links_passive", "cart_three_links_servo"])
def test_a_regulator_balances_what_begins_nearly_upright(name: str) -> None:
    found = Lqr().run(problem(task("balance", load(name))), seed=100)
    assert found.succeeded
    assert found.policy.kind == "linear"


def test_without_a_regulator_the_rider_falls() -> None:
    wanted = task("balance", load("rider_two_links_passive"))
    found = Lqr().run(problem(wanted), seed=100)
    policy = found.policy
    assert isinstance(policy, Linear)
    idle = replace(policy, weight=0.0 * policy.weight, bias=0.0 * policy.bias)
    rng = np.random.default_rng(1)
    assert evaluate(wanted, idle, wanted.simulator(), rng=rng, rows=20).share == 0.0


def test_a_regulator_alone_does_not_swing_up_and_says_so(cartpole: Task) -> None:
    found = Lqr().run(problem(cartpole), seed=100)
    assert not found.succeeded
    assert "begin too far from rest" in found.why


def test_planned_anew_at_every_step_a_pendulum_swings_up() -> None:
    wanted = replace(task("swing-up", load("pendulum")), horizon=1.2)
    found = Receding(rows=32, runs=4, most=1).run(problem(wanted), seed=100)
    assert found.succeeded


def test_settings_that_search_nothing_are_refused() -> None:
    with pytest.raises(SearchError, match="give at least 16 rows"):
        Plan(rows=3)
    with pytest.raises(SearchError, match="give at least 16 rows"):
        Receding(most=0)
    with pytest.raises(SearchError, match="works inside a simulator"):
        Plan().run(Problem(task=task("swing-up", load("pendulum"))), seed=0)
