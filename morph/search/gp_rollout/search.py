"""Shared part of the searches that plan on Gaussian-process dynamics (PILCO and its kin)."""

from __future__ import annotations

import time
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import SearchError
from morph.model.gp.fit import fit
from morph.model.gp.gp import GaussianProcess
from morph.policy.policy import Policy
from morph.search.gp_rollout.memory import Memory
from morph.search.gp_rollout.task import TaskSums, view_of
from morph.search.search import Learned, Problem, Search, State, Told, Trial, ignore


@dataclass(frozen=True, kw_only=True)
class Improved:
    """What a search makes of all trials so far."""

    policy: Policy
    """What is tried next."""
    numbers: Array
    """What it goes on from after the next trial, as one vector."""
    expected: float
    """The loss that is expected of it."""


@dataclass(frozen=True, kw_only=True)
class BeliefSearch(Search):
    """A trial with random commands; then, in turn, learn, improve the policy, and try it."""

    from_trials = True
    kind: ClassVar[type[Policy]]
    """What it makes: of this kind are the numbers that it keeps of what it tried."""

    rounds: int = 6
    """Trials of policies, if nothing else is said."""
    hold: int = 2
    """Control periods for which each random command of the first trial is held."""
    most_data: int = 240
    """Most control periods that the processes are made of; of more, those farthest apart."""

    def __post_init__(self) -> None:
        """Check the settings."""
        if min(self.rounds, self.hold) < 1 or self.most_data < 20:
            raise SearchError(
                f"it would make {self.rounds} trials, hold commands for {self.hold} periods and "
                f"keep {self.most_data}",
                where=f"search {self.name}",
                fix="give 1 or more, and keep at least 20",
            )

    @abstractmethod
    def improved(
        self,
        view: TaskSums,
        process: GaussianProcess,
        memory: Memory,
        rng: np.random.Generator,
    ) -> Improved:
        """Return the policy that is to be tried next."""

    def solve(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        """Return the policy whose trial was the best.

        Raises:
            SearchError: The task or the data do not suit it.
        """
        view, target = view_of(problem.task), problem.trials
        memory = Memory.of(state, problem.task.period)
        begun = time.perf_counter() - memory.seconds
        record: list[Trial] = []
        for number in range(len(memory.runs), (trials or self.rounds) + 1):
            # Each trial has a chance of its own, so that one that is resumed is the same.
            rng = np.random.default_rng((seed, number))
            if number == 0:
                run = target.trial(self.random(view, rng), rng)
                memory, note = memory.after(run), "random commands"
            else:
                process = self.learned(view, memory)
                result = self.improved(view, process, memory, rng)
                run = target.trial(result.policy, rng)
                memory = memory.after(
                    run, tried=result.policy.weights(), process=process, numbers=result.numbers
                )
                note = f"expected {result.expected:.1f}"
            memory = memory.at(time.perf_counter() - begun)
            record.append(
                Trial(
                    number=number,
                    loss=run.loss,
                    success=float(run.success),
                    seconds=memory.seconds,
                    experience=memory.experience,
                    note=note,
                )
            )
            progress(record[-1], memory.state())
        return self._best(view, memory, tuple(record))

    def random(self, view: TaskSums, rng: np.random.Generator) -> Array:
        """Return random commands within their bounds, each held for some periods."""
        low, high = view.bounds
        periods = view.task.samples - 1
        few = rng.uniform(low, high, size=(-(-periods // self.hold), len(low)))
        return np.repeat(few, self.hold, axis=0)[:periods]

    def learned(self, view: TaskSums, memory: Memory) -> GaussianProcess:
        """Return the change of velocity in a period, as trials show it."""
        inputs, targets = memory.data(view)
        return fit(*memory.spread(inputs, targets, self.most_data), before=memory.process)

    def _best(self, view: TaskSums, memory: Memory, record: tuple[Trial, ...]) -> Learned:
        """Return the policy whose trial was the best of all, those before a kill too."""
        run = memory.runs[memory.best]
        policy = self.kind.of(
            memory.tried[memory.best - 1],
            action=view.action,
            period=view.task.period,
            observation=view.observation,
        )
        return Learned(
            policy=policy,
            trials=record,
            succeeded=run.success,
            why=""
            if run.success
            else f"none of {len(memory.tried)} trials reached every goal; the best cost "
            f"{run.loss:.1f}",
            experience=memory.runs,
        )
