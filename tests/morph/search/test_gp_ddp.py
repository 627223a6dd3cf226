"""A pendulum is swung up from a few trials, with no simulator to search in."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from morph.arrays import Array
from morph.body.load import load
from morph.errors import SearchError
from morph.policy.policy import Policy
from morph.search.gp_ddp import LearnedPlans
from morph.search.learned_dynamics.memory import recalled
from morph.search.learned_dynamics.plans import TrialBudget
from morph.search.search import Learned, Problem, State, Trial
from morph.search.target import Experience, Simulated, Target
from morph.task.task import Task
from morph.task.tasks import task

SMALL = LearnedPlans(
    effort=TrialBudget(
        rows=100, keep=2, most=8, margins=(0.1,), rhos=(10.0,), bodies=(16, 32), best=2
    )
)


@pytest.fixture(scope="module")
def swing() -> Task:
    return task("swing-up", load("pendulum"))


@dataclass(frozen=True, kw_only=True)
class Counted(Target):
    """A target that counts its trials."""

    real: Simulated
    """What they are made on."""
    seen: list[Experience] = field(default_factory=list)
    """What they showed."""

    def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
        """Return one run, and count it."""
        self.seen.append(self.real.trial(policy, rng))
        return self.seen[-1]


def counted(swing: Task) -> Counted:
    return Counted(real=Simulated(task=swing, simulator=swing.simulator()))


Told = list[tuple[Trial, State]]


@pytest.fixture(scope="module")
def whole(swing: Task) -> tuple[Learned, Told, Counted]:
    told: Told = []
    target = counted(swing)
    learned = SMALL.run(
        Problem(task=swing, target=target),
        seed=100,
        trials=2,
        progress=lambda trial, state: told.append((trial, state)),
    )
    return learned, told, target


def test_a_pendulum_is_swung_up_within_two_trials(whole: tuple[Learned, Told, Counted]) -> None:
    learned, _, _ = whole
    assert learned.succeeded
    assert learned.why == ""
    # Hanging still for 3 s costs 61; the top is reached within a second.
    assert learned.trials[-1].loss < 20.0


def test_every_trial_is_told_and_no_more_are_made(whole: tuple[Learned, Told, Counted]) -> None:
    learned, told, target = whole
    assert [trial.number for trial, _ in told] == list(range(len(told)))
    assert len(target.seen) == len(told) == len(learned.experience) <= 3
    assert told[-1][0].experience == pytest.approx(3.0 * len(told))


def test_a_search_resumed_after_its_first_trial_ends_as_if_it_had_not_been_stopped(
    swing: Task, whole: tuple[Learned, Told, Counted]
) -> None:
    learned, told, _ = whole
    again = SMALL.run(
        Problem(task=swing, target=counted(swing)), seed=100, trials=2, state=told[0][1]
    )
    assert [trial.loss for trial in again.trials] == pytest.approx(
        [trial.loss for trial in learned.trials], rel=1e-6
    )
    for name, value in learned.policy.weights().items():
        assert again.policy.weights()[name] == pytest.approx(value, abs=1e-6)


def test_what_is_kept_is_what_is_recalled(whole: tuple[Learned, Told, Counted]) -> None:
    state = whole[1][-1][1]
    again = recalled(state).state()
    assert set(again) == set(state)
    for name, value in state.items():
        assert np.array_equal(again[name], value)


def test_a_body_that_never_moved_is_named_with_its_joint_and_its_task(swing: Task) -> None:
    @dataclass(frozen=True, kw_only=True)
    class Stuck(Simulated):
        """A robot whose brake is on, or whose joint spins as fast as nothing can."""

        speed: float = 0.0

        def trial(self, policy: Policy | Array, rng: np.random.Generator) -> Experience:
            shown = super().trial(policy, rng)
            turned = self.speed * shown.period * np.arange(len(shown.position))[:, None]
            speed = np.full_like(shown.velocity, self.speed)
            return replace(shown, position=turned, velocity=speed)

    joint = swing.robot.joints[0].name
    for speed, what in ((0.0, "kept its velocity"), (100.0, "turned by more than 1.2 rad")):
        stuck = Stuck(task=swing, simulator=swing.simulator(), speed=speed)
        with pytest.raises(SearchError, match=what) as found:
            SMALL.run(Problem(task=swing, target=stuck), seed=100, trials=1)
        assert found.value.where == "search gp-ddp on swing-up of pendulum"
        assert f"joint {joint!r}" in found.value.what
        assert found.value.fix.startswith("take another seed")


def test_nothing_to_try_on_or_nothing_to_read_is_refused(swing: Task) -> None:
    with pytest.raises(SearchError, match="nothing to make them on"):
        SMALL.run(Problem(task=swing), seed=0)
    with pytest.raises(SearchError, match="its state cannot be read"):
        SMALL.run(Problem(task=swing, target=counted(swing)), seed=0, state={})
    with pytest.raises(SearchError, match="it is given 0 trials"):
        SMALL.run(Problem(task=swing, target=counted(swing)), seed=0, trials=0)
    with pytest.raises(SearchError, match="held for 0 s"):
        LearnedPlans(hold=0.0)
