"""The family of baselines: ways to use a source on a target, trial by trial."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import TransferError
from morph.policy.policy import Policy
from morph.policy_transfer.baselines.source import Source
from morph.search.learned_dynamics.memory import SearchCheckpoint
from morph.search.learned_dynamics.plan_choice import Plans
from morph.search.learned_dynamics.plans import TrialBudget
from morph.search.search import Trial
from morph.search.target import Target
from morph.sim.threads import one_thread

LIGHT = TrialBudget(
    rows=200, keep=3, most=10, margins=(0.05, 0.15), rhos=(2.0, 10.0), bodies=(16, 48), best=4
)
"""What is computed for a trial, if nothing else is said: a fifth of what gp-ddp takes."""


@dataclass(frozen=True, kw_only=True)
class NextStep:
    """What is tried next."""

    policy: Policy | Array
    """A policy, or a command for each control period, shape (periods, nu)."""
    plan: Plans | None = None
    """The same as a plan, if it is one."""
    logs: Array | None = None
    """Logarithms of the settings of the model that it was made in, if there is one."""
    note: str = ""
    """What is to be known of it besides."""


@dataclass(frozen=True, kw_only=True)
class Baseline(ABC):
    """A way to use a source on a target; its fields are its settings."""

    name: ClassVar[str]
    """What studies call it."""

    effort: TrialBudget = LIGHT
    """How much is computed for each trial."""

    def run(self, source: Source, target: Target, *, trials: int, seed: int) -> tuple[Trial, ...]:
        """Return the record of so many trials on the target, counted from 1.

        The chance of a trial, its start and its noise, is drawn from the seed and its number
        alone, so that rivals meet the same.

        Args:
            source: What is brought along.
            target: What trials are made on.
            trials: How many.
            seed: Chance begins from it.

        Raises:
            TransferError: There are no trials, or the source lacks what the rival brings along.
            SearchError: The trials show too little to learn from.
        """
        if trials < 1:
            raise TransferError(
                f"it is given {trials} trials",
                where=f"rival {self.name} on {source.task.name} of {source.task.robot.name}",
                fix="give one trial or more",
            )
        self.check(source)
        with one_thread():
            return self._run(source, target, trials, seed)

    def _run(self, source: Source, target: Target, trials: int, seed: int) -> tuple[Trial, ...]:
        began, memory = time.perf_counter(), SearchCheckpoint()
        for number in range(1, trials + 1):
            step = self.step(source, memory, np.random.default_rng([seed, number, 0]))
            shown = target.trial(step.policy, np.random.default_rng([seed, number, 1]))
            seconds = time.perf_counter() - began
            memory = memory.after(shown, step.plan, seconds, step.note)
            memory = replace(memory, logs=memory.logs if step.logs is None else step.logs)
        return tuple(replace(line, number=at) for at, line in enumerate(memory.lines, 1))

    def check(self, source: Source) -> None:
        """Raise a `TransferError` if the source lacks what the rival brings along."""

    @abstractmethod
    def step(self, source: Source, memory: SearchCheckpoint, rng: np.random.Generator) -> NextStep:
        """Return what is tried next, after all that was seen on the target."""


def needs_experience(rival: Baseline, source: Source) -> None:
    """Refuse a source of which nothing was seen.

    Raises:
        TransferError: It is one.
    """
    if not source.experience:
        raise TransferError(
            "the source brings no experience",
            where=f"rival {rival.name} on {source.task.name} of {source.task.robot.name}",
            fix="give runs of the source, such as `lived` makes",
        )
