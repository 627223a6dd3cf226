"""Searches by generations: they find minima, go on after a kill, and say when they failed."""

from dataclasses import replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.errors import SearchError
from morph.search.cmaes import Adapting, CmaEs
from morph.search.evolution import Anywhere, Evolution, IsotropicNormal, RandomSearch
from morph.search.generations.generations import Generations, Sampler
from morph.search.search import Problem, State, Trial
from morph.task.reach import reach
from morph.task.task import Task

SEARCHES = (CmaEs, Evolution, RandomSearch)


def valley(points: Array) -> Array:
    """Return a quadratic along a turned axis that is ten times as steep as across it."""
    x, y = (points - 0.7).T[:2]
    return 100.0 * (x + y) ** 2 + (x - y) ** 2 + ((points[:, 2:] - 0.4) ** 2).sum(axis=1)


def least(sampler: Sampler, generations: int) -> float:
    rng = np.random.default_rng(5)
    best = np.inf
    for _ in range(generations):
        points = sampler.ask(10, rng)
        assert ((points >= 0.0) & (points <= 1.0)).all()
        losses = valley(points)
        sampler.tell(points, losses)
        best = min(best, float(losses.min()))
    return best


def test_a_covariance_beats_a_round_spread_and_both_beat_chance() -> None:
    start = np.full(4, 0.2)
    adapted = least(Adapting(start, 0.25, 10, None), 80)
    round_ = least(IsotropicNormal(start, 0.25), 80)
    anywhere = least(Anywhere(start), 80)
    assert adapted < 1e-8
    assert adapted < round_ < anywhere
    # 800 points in the cube of 4 sides: the nearest is some 800^(-1/4) / 2 = 0.1 away.
    assert anywhere > 1e-4


@pytest.fixture(scope="module")
def far() -> Task:
    """Return a reach that asks for two millimetres within a second: more than servos follow."""
    return replace(reach(load("so101"), within=0.002), horizon=1.0)


def problem(task: Task) -> Problem:
    return Problem(task=task, simulator=task.simulator())


def quick(search: type[Generations]) -> Generations:
    return search(population=6, runs=1, checks=2, generations=4)


@pytest.mark.parametrize("search", SEARCHES)
def test_a_search_that_was_killed_goes_on_as_if_it_had_not_been(
    search: type[Generations], far: Task
) -> None:
    states: list[State] = []
    whole = quick(search).run(
        problem(far), seed=100, progress=lambda _, state: states.append(state)
    )
    assert len(states) == 4
    kept = {name: np.array(value) for name, value in states[1].items()}
    rest = quick(search).run(problem(far), seed=100, state=kept)
    assert [trial.number for trial in rest.trials] == [3, 4]
    assert [trial.loss for trial in rest.trials] == [trial.loss for trial in whole.trials[2:]]
    for name, value in whole.policy.weights().items():
        np.testing.assert_array_equal(rest.policy.weights()[name], value)


def test_a_search_that_failed_says_so_and_gives_its_best(far: Task) -> None:
    told: list[Trial] = []
    learned = CmaEs(population=6, runs=1, checks=2).run(
        problem(far), seed=101, trials=2, progress=lambda trial, _: told.append(trial)
    )
    assert tuple(told) == learned.trials
    assert not learned.succeeded
    assert "after 2 generations of 6 policies" in learned.why
    assert learned.policy.act(np.empty((1, 0)), np.zeros(1)).shape == (1, 6)


def test_a_posture_by_inverse_kinematics_succeeds_at_once() -> None:
    task = reach(load("so101"))
    learned = quick(CmaEs).run(problem(task), seed=100)
    assert learned.succeeded
    assert not learned.why
    assert len(learned.trials) == 1


@pytest.mark.parametrize("search", SEARCHES)
def test_a_search_that_was_content_when_it_was_killed_makes_no_further_generation(
    search: type[Generations],
) -> None:
    task = reach(load("so101"))
    states: list[State] = []
    whole = quick(search).run(
        problem(task), seed=100, progress=lambda _, state: states.append(state)
    )
    assert len(whole.trials) < 4
    rest = quick(search).run(problem(task), seed=100, state=states[-1])
    assert rest.trials == ()
    assert rest.policy == whole.policy


def test_settings_that_cannot_be_are_refused() -> None:
    with pytest.raises(SearchError, match="at least 4 policies"):
        CmaEs(population=2)
    with pytest.raises(SearchError, match="sigma of 3"):
        Evolution(sigma=3.0)


def test_a_state_of_another_search_is_refused(far: Task) -> None:
    state = {
        "best.point": np.zeros(3),
        "mean": np.zeros(3),
        "sigma": np.ones(()),
        "path": np.zeros(3),
    }
    with pytest.raises(SearchError, match="its state has 3 free numbers, and the family 6"):
        quick(Evolution).run(problem(far), seed=0, state=state)


def test_a_search_without_a_simulator_says_what_it_needs(far: Task) -> None:
    with pytest.raises(SearchError, match="works inside a simulator"):
        quick(CmaEs).run(Problem(task=far), seed=0)
