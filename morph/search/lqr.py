"""The regulator as a search: the linear policy that holds a body where its task asks."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.search.plan.evaluate_plan import concluded_at_once
from morph.search.plan.policy import linear_of
from morph.search.plan.terminal_controller import held
from morph.search.regulator.rest import rest
from morph.search.search import Learned, Problem, Search, State, Told, ignore
from morph.search.trajectory.plant import Plant


@dataclass(frozen=True, kw_only=True)
class Lqr(Search):
    """The linear-quadratic regulator about the state of rest that the task's goals ask for.

    It looks for no way there: for tasks that begin close to where they end, such as balance.

    Source: Anderson and Moore 1990, Optimal Control: Linear Quadratic Methods.
    """

    name: ClassVar[str] = "lqr"

    def solve(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        """Return the regulator as a policy; it takes one round, and has nothing to go on from."""
        del trials, state
        task, began = problem.task, time.monotonic()
        plant = Plant(problem.model, task.period)
        still = rest(task, plant, np.random.default_rng(seed))
        policy = linear_of(task, plant, still, held(task, plant, still))
        return concluded_at_once(
            problem,
            policy,
            seed=seed,
            began=began,
            progress=progress,
            what="the regulator",
            hint="the run may begin too far from rest, or the noise be too loud",
        )
