"""Receding horizon: a plan that is made anew at every control step, from what is seen."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.errors import SearchError
from morph.search.plan.evaluate_plan import concluded_at_once
from morph.search.plan.feedback import feedback
from morph.search.plan.initial_trajectories import SeedInputs, costed, led, swung
from morph.search.plan.plan_selection import joined, judged
from morph.search.plan.policy import track_of
from morph.search.plan.terminal_controller import grounded
from morph.search.search import Learned, Problem, Search, State, Told, ignore
from morph.search.trajectory.backward import FeedbackLaw
from morph.search.trajectory.ddp import Trajectories, ddp, follow

EFFORTS = (1.0, 3.0, 10.0)
"""What feedback that leads back to a plan may cost, in costs of the regulator's."""


@dataclass(frozen=True, kw_only=True)
class Receding(Search):
    """A run that plans the rest of itself anew at every control step, and its trace as a policy.

    Each plan begins as what is left of the one before, led back to what is seen now by its own
    feedback, and takes a few steps of differential dynamic programming. What the run did becomes
    the nominal of a policy with feedback; the planning itself is not stored.

    Source: Tassa, Erez and Todorov 2012, Synthesis and stabilization of complex behaviors through
    online trajectory optimization, IROS; here the horizon ends where the task's does.
    """

    name: ClassVar[str] = "receding"

    rows: int = 768
    """Bang-bang swings that are drawn for the first plan."""
    first: int = 10
    """Steps of dynamic programming before the run begins."""
    runs: int = 32
    """Noisy runs by which the feedback along the trace is chosen."""
    most: int = 2
    """Steps of dynamic programming at each control step."""

    margin: float = 0.2
    """Share of each command's range, at both its ends, that the first plan leaves to the later
    ones: a plan at its bounds cannot be mended in one direction."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        if self.rows < 16 or min(self.most, self.first, self.runs) < 1:
            raise SearchError(
                f"it draws {self.rows} rows and takes {self.first} and then "
                f"{self.most} steps, and {self.runs} runs",
                where="the search receding",
                fix="give at least 16 rows, and 1 of each other",
            )

    def solve(
        self,
        problem: Problem,
        *,
        seed: int,
        trials: int | None = None,
        progress: Told = ignore,
        state: State | None = None,
    ) -> Learned:
        """Return the trace of one run as a policy; it takes one round, with nothing to resume."""
        del trials, state
        task, began = problem.task, time.monotonic()
        rng = np.random.default_rng(seed)
        ground = grounded(task, problem.model, margin=self.margin, rng=rng)
        guesses = [swung(ground, self.rows, 2, rng)]
        if ground.plant.model.nu >= ground.plant.model.nv:
            guesses.append(led(ground, 2))
        guess = joined(guesses)
        first = guess.rows(np.array([int(np.argmin(guess.cost))]))
        first = ddp(ground.plant, ground.cost, first, margin=self.margin, most=self.first)
        trace = followed(ground, first, self.most, rng)
        policy = track_of(ground, judged(ground, trace, runs=self.runs, rng=rng))
        return concluded_at_once(
            problem,
            policy,
            seed=seed,
            began=began,
            progress=progress,
            what="the trace of its run",
            hint="the search ddp chooses among several plans",
        )


def followed(
    ground: SeedInputs, plan: Trajectories, most: int, rng: np.random.Generator
) -> Trajectories:
    """Return what a body does that is told the first command of an ever new plan, one row.

    Args:
        ground: The task and the body.
        plan: The first plan, one row.
        most: Steps of dynamic programming at each control step.
        rng: The chance of the start and of what is seen.
    """
    plant, task = ground.plant, ground.cost.task
    low, high = plant.low, plant.high
    periods = plan.command.shape[1]
    q, v, u = np.copy(plan.position), np.copy(plan.velocity), np.copy(plan.command)
    q[:, 0], v[:, 0] = task.start.sample(task.robot, plant.model, 1, rng)
    for at in range(periods):
        seen = (
            q[:, at] + rng.normal(scale=task.noise, size=q[:, at].shape),
            v[:, at] + rng.normal(scale=task.noise, size=v[:, at].shape),
        )
        gains = [feedback(ground, plan, effort) for effort in EFFORTS]
        many = joined([plan] * len(EFFORTS))
        law = FeedbackLaw(
            change=np.zeros_like(many.command),
            gain=np.concatenate(gains),
            promised=np.zeros(len(EFFORTS)),
        )
        edge = np.broadcast_to(low, many.command.shape), np.broadcast_to(high, many.command.shape)
        back = follow(
            plant,
            many,
            law,
            *edge,
            begin=(
                np.repeat(seen[0], len(EFFORTS), axis=0),
                np.repeat(seen[1], len(EFFORTS), axis=0),
            ),
        )
        back = costed(ground, back.position, back.velocity, back.command)
        start = back.rows(np.array([int(np.argmin(back.cost))]))
        plan = ddp(plant, ground.cost, start, most=most)
        u[:, at] = plan.command[:, 0]
        q[:, at + 1], v[:, at + 1] = plant.advance(q[:, at], v[:, at], u[:, at])
        plan = Trajectories(
            position=plan.position[:, 1:],
            velocity=plan.velocity[:, 1:],
            command=plan.command[:, 1:],
            cost=plan.cost,
        )
    return costed(ground, q, v, u)
