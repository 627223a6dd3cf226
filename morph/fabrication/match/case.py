"""What a way of matching is given: the policy, both bodies, and the time that is left."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from morph.policy.policy import Policy
from morph.search.evaluate import Score, evaluate
from morph.sim.simulator import Simulator
from morph.task.task import Task

CHOOSING, JUDGING = 2**31 - 4, 2**31 - 5
"""Names of the chance of the runs that choose and that judge: that of no search."""

FIRST, MOST = 10, 100
"""Fewest and most runs by which a policy is judged."""

SHARE = 0.06
"""Share of the time that one judgement may take."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A policy that was learned on one body, and the body that it is to command now."""

    policy: Policy
    """What commands the printed body until now."""
    learned: Policy
    """What was learned on the designed body; the same if nothing was matched yet."""
    designed: Task
    """The task of the body as it was designed."""
    printed: Task
    """The same task of the body as it was printed."""
    seconds: float
    """How long matching may take, all together, s."""
    seed: int = 0
    """Chance begins from it."""
    told: Callable[[str], None] = lambda said: None
    """Is told what is going on."""
    began: float = field(default_factory=time.monotonic)
    """When it began, by `time.monotonic`, s."""

    @property
    def left(self) -> float:
        """How much of the time is left, s, the last choice and judgement set aside."""
        aside = (self.rows + max(FIRST, self.rows // 2)) * self.each
        return self.seconds - (time.monotonic() - self.began) - aside

    @cached_property
    def drawing_board(self) -> Simulator:
        """The designed body."""
        return self.designed.simulator()

    @cached_property
    def bench(self) -> Simulator:
        """The printed body."""
        return self.printed.simulator()

    @cached_property
    def each(self) -> float:
        """How long a run takes in a batch, s."""
        begun = time.monotonic()
        self.chosen(self.policy, rows=FIRST)
        return (time.monotonic() - begun) / FIRST

    @cached_property
    def rows(self) -> int:
        """By how many runs a policy is judged."""
        return int(np.clip(SHARE * self.seconds / self.each, FIRST, MOST))

    def judged(self, policy: Policy, *, on: Task | None = None, rows: int = 0) -> Score:
        """Return how a policy does in runs that chose nothing, on the printed body or another."""
        task, simulator = (self.printed, self.bench) if on is None else (on, self.drawing_board)
        rng = np.random.default_rng([self.seed, JUDGING])
        return evaluate(task, policy, simulator, rng=rng, rows=rows or self.rows)

    def chosen(self, policy: Policy, *, rows: int = 0) -> Score:
        """Return how a policy does on the printed body in the runs by which one is chosen."""
        rng = np.random.default_rng([self.seed, CHOOSING])
        rows = rows or max(FIRST, self.rows // 2)
        return evaluate(self.printed, policy, self.bench, rng=rng, rows=rows)
