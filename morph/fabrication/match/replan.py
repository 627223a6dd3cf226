"""Optimise the plan again on the printed body, starting from what the policy does there."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from morph.fabrication.match.case import Case
from morph.fabrication.match.matcher import Matcher
from morph.policy.policy import Policy
from morph.search.plan.replan import STAGES, again
from morph.search.searches import DEFAULTS, OTHERWISE, default

LONGER = 4.0
"""How many times as long as the last a stage may take."""


@dataclass(frozen=True, kw_only=True)
class Replan(Matcher):
    """Differential dynamic programming that begins with what the policy does now.

    The first stages begin with the policy's own commands; only the later ones, which are reached
    where no plan does the task, draw fresh swings.
    """

    name: ClassVar[str] = "plan"
    dear: ClassVar[bool] = True

    def suits(self, case: Case) -> bool:
        """Return whether the task is one for plans."""
        task = case.printed
        return task.name in DEFAULTS and default(task.name, task.robot) != OTHERWISE

    def proposals(self, case: Case) -> Iterator[Policy]:
        """Yield a plan of each stage that there is time for."""
        took = 0.0
        for number, stage in enumerate(STAGES, start=1):
            if case.left <= LONGER * took:
                return
            begun = time.monotonic()
            case.told(f"planning again, stage {number} of {len(STAGES)}")
            result = again(case.printed, case.bench, case.policy, seed=case.seed, stages=(stage,))
            took = time.monotonic() - begun
            yield result.policy
