"""Feedback anew: the regulator of the printed body."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.fabrication.match.case import Case
from morph.fabrication.match.matcher import Matcher
from morph.policy.linear import Linear
from morph.policy.policy import Policy
from morph.search.lqr import Lqr
from morph.search.plan.policy import linear_of
from morph.search.plan.terminal_controller import held
from morph.search.regulator.rest import rest
from morph.search.searches import default
from morph.search.trajectory.plant import Plant


@dataclass(frozen=True, kw_only=True)
class RegulatorMatcher(Matcher):
    """The linear-quadratic regulator about the state of rest of the printed body.

    A linear policy whose gains weigh sway against noise is best for one body: with other masses
    the same weighing gives other gains, at the cost of one Riccati equation.
    """

    name: ClassVar[str] = "regulator"

    def suits(self, case: Case) -> bool:
        """Return whether the policy is linear and its task one for regulators."""
        task = case.printed
        return isinstance(case.policy, Linear) and default(task.name, task.robot) == Lqr.name

    def proposals(self, case: Case) -> Iterator[Policy]:
        """Yield the regulator."""
        task = case.printed
        plant = Plant(case.bench, task.period)
        still = rest(task, plant, np.random.default_rng(case.seed))
        yield linear_of(task, plant, still, held(task, plant, still))
