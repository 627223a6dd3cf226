"""How a policy does on the printed body beside what it did on the designed one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.search.evaluate import Score
from morph.task.task import UNSTABLE

ALLOWED = 0.02
"""Share of the task's span by which the loss may grow, and of the runs that may fail more."""

WORTH = 0.1
"""Share of the loss itself by which it may grow before a cheap match is tried though it holds."""


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Losses of runs that begin and are seen alike.

    The span of a task is what doing nothing costs beyond what the policy costs, both on the
    designed body: a policy that does nothing has lost all of it. Where doing nothing costs no
    more, the span is the policy's own loss.
    """

    designed: Score
    """The policy as it was learned, on the designed body."""
    printed: Score
    """The policy looked at, on the printed body."""
    still: Score
    """Every command zero, on the designed body."""

    @property
    def span(self) -> float:
        """What there is to lose."""
        nothing = self.still.loss[self.still.loss < UNSTABLE]
        more = float(nothing.mean()) - self.designed.mean if len(nothing) else 0.0
        return more if more > 0.0 else abs(self.designed.mean)

    @property
    def growth(self) -> float:
        """By how much of the span the mean loss grew; below 0 it fell."""
        grown = self.printed.mean - self.designed.mean
        if grown == 0.0:
            return 0.0
        return grown / self.span if self.span > 0.0 else float(np.sign(grown)) * np.inf

    @property
    def steady(self) -> bool:
        """Whether it succeeds as often as the policy did on the designed body."""
        return self.printed.share >= self.designed.share - ALLOWED

    @property
    def holds(self) -> bool:
        """Whether the policy does on the printed body what it did on the designed one."""
        return self.steady and self.growth <= ALLOWED

    @property
    def sure(self) -> bool:
        """Whether it holds with half of what is allowed to spare, for runs that only choose."""
        return self.steady and self.growth <= 0.5 * ALLOWED

    @property
    def close(self) -> bool:
        """Whether it does so well that there is nothing to match."""
        grown = self.printed.mean - self.designed.mean
        return self.holds and grown <= WORTH * abs(self.designed.mean)
