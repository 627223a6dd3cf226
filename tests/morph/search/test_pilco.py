from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.errors import SearchError, StateError
from morph.policy.policy import Policy
from morph.search.gp_rollout.search import BeliefSearch
from morph.search.mc_pilco import McPilco
from morph.search.pddp import Pddp
from morph.search.pilco import Pilco
from morph.search.search import Problem, State, Trial
from morph.search.target import Experience, Simulated
from morph.task.task import Task
from morph.task.tasks import task

SMALL: tuple[BeliefSearch, ...] = (
    Pilco(units=8, steps=12, short=4, starts=1),
    McPilco(units=8, particles=20, steps=6, starts=2),
    Pddp(steps=4, samples=50, starts=1, widths=(2.0, 1.0)),
)


@pytest.fixture(scope="module")
def short() -> Task:
    """Swing up for a second: a start, and nothing that could be reached."""
    return replace(task("swing-up", load("cartpole")), horizon=1.0)


@pytest.fixture(scope="module")
def problem(short: Task) -> Problem:
    return Problem(task=short, target=Simulated(task=short, simulator=short.simulator()))


@pytest.mark.parametrize("search", SMALL, ids=lambda each: each.name)
def test_a_killed_search_goes_on_to_the_same_policy(search: BeliefSearch, problem: Problem) -> None:
    states: list[tuple[Trial, State]] = []
    whole = search.run(problem, seed=5, trials=2, progress=lambda *said: states.append(said))
    _, after_first = states[1]
    copy = {name: np.array(value) for name, value in after_first.items()}
    resumed = search.run(problem, seed=5, trials=2, state=copy)
    assert [trial.number for trial in whole.trials] == [0, 1, 2]
    assert [trial.number for trial in resumed.trials] == [2]
    assert resumed.experience[2].loss == whole.experience[2].loss
    assert np.array_equal(resumed.experience[2].command, whole.experience[2].command)
    assert resumed.policy == whole.policy
    assert resumed.why == whole.why


class Fading(Simulated):
    """A target on which each trial is said to cost one more than the one before."""

    made: ClassVar[list[Policy | Array]] = []

    def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
        self.made.append(policy)
        return replace(super().trial(policy, rng), loss=float(len(self.made)))


@pytest.mark.parametrize("search", SMALL, ids=lambda each: each.name)
@pytest.mark.parametrize("trials", [1, 2, 3])
def test_a_search_that_goes_on_still_knows_the_best_before_the_kill(
    search: BeliefSearch, trials: int, short: Task, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Policy | Array] = []
    monkeypatch.setattr(Fading, "made", made)
    problem = Problem(task=short, target=Fading(task=short, simulator=short.simulator()))
    states: list[State] = []
    search.run(problem, seed=8, trials=2, progress=lambda _, state: states.append(state))
    found = search.run(problem, seed=8, trials=trials, state=states[-1])
    # The second one after the random commands cost more; those before it are no policy.
    assert found.policy == made[1]
    assert len(made) == max(3, trials + 1)
    assert f"none of {max(2, trials)} trials" in found.why


def test_policies_that_are_missing_are_not_overlooked(problem: Problem) -> None:
    states: list[State] = []
    SMALL[0].run(problem, seed=8, trials=1, progress=lambda _, state: states.append(state))
    spoilt = {name: each for name, each in states[1].items() if not name.startswith("tried.")}
    with pytest.raises(StateError, match="2 trials, and 0 policies"):
        SMALL[0].run(problem, seed=8, trials=2, state=spoilt)


@pytest.mark.parametrize("search", SMALL, ids=lambda each: each.name)
def test_a_start_that_is_known_exactly_is_no_obstacle(search: BeliefSearch, short: Task) -> None:
    exact = replace(short, start=replace(short.start, spread=0.0))
    problem = Problem(task=exact, target=Simulated(task=exact, simulator=exact.simulator()))
    assert len(search.run(problem, seed=9, trials=1).trials) == 2


@pytest.mark.parametrize("search", SMALL, ids=lambda each: each.name)
def test_a_search_that_failed_says_so(search: BeliefSearch, problem: Problem) -> None:
    found = search.run(problem, seed=6, trials=1)
    # In a second the pole cannot be swung up and held for half of it.
    assert not found.succeeded
    assert "none of 1 trials reached every goal" in found.why
    assert found.experience[-1].seconds == pytest.approx(1.0)


@pytest.mark.parametrize("search", SMALL, ids=lambda each: each.name)
def test_an_expected_loss_is_that_of_the_trial_once_the_body_is_known(
    search: BeliefSearch, problem: Problem
) -> None:
    notes: list[Trial] = []
    search.run(problem, seed=7, trials=3, progress=lambda trial, state: notes.append(trial))
    expected = float(notes[-1].note.split()[-1])
    # 21 samples of at most 1; from 80 periods the body is known near where it went.
    assert expected == pytest.approx(notes[-1].loss, abs=1.5)


def test_data_that_are_no_numbers_are_refused(short: Task) -> None:
    class Broken(Simulated):
        def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
            found = super().trial(policy, rng)
            return replace(found, velocity=np.full_like(found.velocity, np.nan))

    problem = Problem(task=short, target=Broken(task=short, simulator=short.simulator()))
    with pytest.raises(SearchError, match="no finite number"):
        SMALL[0].run(problem, seed=1, trials=1)


def test_random_commands_stay_within_their_bounds_and_are_held(short: Task) -> None:
    from morph.search.gp_rollout.task import view_of

    view = view_of(short)
    told: Array = replace(SMALL[0], hold=4).random(view, np.random.default_rng(0))
    low, high = view.bounds
    assert told.shape == (20, 1)
    assert ((told >= low) & (told <= high)).all()
    assert (told.reshape(5, 4, 1) == told[::4, None]).all()


def test_settings_without_sense_are_refused() -> None:
    with pytest.raises(SearchError, match="keep at least 20"):
        Pilco(most_data=3)
    with pytest.raises(SearchError, match="effort"):
        Pddp(effort=0.0)
