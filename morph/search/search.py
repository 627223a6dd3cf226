"""The family of searches: from a task and a simulator, or from trials alone, to a policy."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from morph.arrays import Array
from morph.errors import SearchError
from morph.policy.policy import Policy
from morph.search.target import Experience, Simulated, Target
from morph.sim.simulator import Simulator
from morph.sim.threads import one_thread
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True)
class Problem:
    """What a search is given."""

    task: Task
    """What is to be done."""
    simulator: Simulator | None = None
    """A simulation to search in; None if nothing is known but trials."""
    target: Target | None = None
    """What trials are made on; None if the simulator is all there is."""

    @property
    def model(self) -> Simulator:
        """The simulation to search in.

        Raises:
            SearchError: There is none.
        """
        if self.simulator is None:
            raise SearchError(
                "this search works inside a simulator, and none is given",
                where=f"task {self.task.name} of {self.task.robot.name}",
                fix="give a simulator, or take a search that learns from trials alone",
            )
        return self.simulator

    @property
    def trials(self) -> Target:
        """What trials are made on.

        Raises:
            SearchError: There is nothing.
        """
        if self.target is None:
            raise SearchError(
                "this search learns from trials, and there is nothing to make them on",
                where=f"task {self.task.name} of {self.task.robot.name}",
                fix="give a target: a simulation that stands for the robot, or the robot",
            )
        return self.target


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One line of the learning record: a trial on the target, a generation, or a round."""

    number: int
    """Counted from 1; 0 is the trial with random commands that some searches begin with."""
    loss: float
    """Loss of the best policy so far or, of a search from trials, of this trial."""
    success: float
    """Share of runs that reached every goal; 0 or 1 for one trial."""
    seconds: float
    """Wall time since the search began, s."""
    experience: float = 0.0
    """Time on the target since the search began, s."""
    note: str = ""
    """What is to be known of it besides."""


@dataclass(frozen=True, kw_only=True)
class Learned:
    """What a search gives back."""

    policy: Policy
    """The best policy that it found."""
    trials: tuple[Trial, ...]
    """The learning record."""
    succeeded: bool
    """Whether that policy reached every goal when it was tried at the end."""
    why: str = ""
    """If not: why, in one sentence."""
    experience: tuple[Experience, ...] = ()
    """Every trial on the target."""


def check_numbers(trials: int | None, seed: int) -> None:
    """Refuse a number of trials or a random seed that no search can take.

    Raises:
        SearchError: There would be no trial, or the seed is negative.
    """
    if trials is not None and trials < 1:
        raise SearchError(
            f"a search of {trials} trials learns nothing",
            where="--trials",
            fix="give at least 1, or leave it out",
        )
    if seed < 0:
        raise SearchError(f"{seed} is no seed", where="--seed", fix="give 0 or more")


State = Mapping[str, Array]
"""All that a search needs to go on after a kill, as arrays by name."""

Told = Callable[[Trial, State], None]
"""What is called after each trial, generation or round."""


def ignore(trial: Trial, state: State) -> None:
    """Take no notice."""


@dataclass(frozen=True, kw_only=True)
class Search(ABC):
    """A way to a policy; its fields are its settings, listed in `morph/search/searches.py`."""

    name: ClassVar[str]
    """What `morph learn --search` calls it."""
    from_trials: ClassVar[bool] = False
    """Whether it learns from trials on the target alone, without a simulator."""

    def problem(self, task: Task) -> Problem:
        """Return a task with a simulation that stands for the robot, to search in or to try on."""
        simulator = task.simulator()
        target = Simulated(task=task, simulator=simulator)
        return Problem(task=task, simulator=None if self.from_trials else simulator, target=target)

    def run(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        """Return the best policy found; a search that failed says so and why.

        Args:
            problem: The task, and where to search.
            seed: Chance begins from it; the same seed gives the same policy.
            trials: Most trials on the target, generations or rounds; None for the search's own.
            progress: Is called after each.
            state: What `progress` was last given, to go on from there.

        Raises:
            SearchError: The search cannot be made on this task, or not from this data.
        """
        with one_thread():
            return self.solve(problem, seed=seed, trials=trials, progress=progress, state=state)

    @abstractmethod
    def solve(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        """Return what `run` is to give back; numerical libraries keep to one thread meanwhile."""
