"""Plans in learned dynamics: initial guesses, optimised, each with several feedback gains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.model.jointed.draws import draw
from morph.search.learned_dynamics.learned_body import Dream
from morph.search.learned_dynamics.plan_choice import (
    PlanPredictions,
    Plans,
    foreseen,
    joined,
    with_feedback,
)
from morph.search.learned_dynamics.rest_feedback import aim, ground_of
from morph.search.plan.initial_trajectories import swung
from morph.search.trajectory.ddp import Trajectories, ddp
from morph.task.task import Task

HOPELESS = 10.0
"""Loss beyond that of the best guess from which another is not improved."""

APART = 0.03
"""Mean difference of commands, in halves of their ranges, below which two guesses are one."""

GENTLE, HELD = 0.3, 4
"""Share of the bounds, and control periods, of random commands where no plan can be made."""

WORTHWHILE = 0.02
"""By how much a new plan must promise to be better than one that was tried, as a share."""

FAILURE = 3.0
"""What a run that fails counts beyond its loss, in mean losses, when plans are compared."""


@dataclass(frozen=True, kw_only=True)
class TrialBudget:
    """How much is computed for a trial."""

    rows: int = 500
    """Swings that are drawn first for each margin."""
    keep: int = 5
    """Swings of each margin that are improved."""
    most: int = 20
    """Most steps of differential dynamic programming."""
    margins: tuple[float, ...] = (0.05, 0.1, 0.2)
    """Shares of the commands' range that plans leave free at both ends, for the feedback."""
    rhos: tuple[float, ...] = (2.0, 10.0, 50.0)
    """Costs of effort, against the widths of the goals, for which feedback is made."""
    bodies: tuple[int, int] = (64, 256)
    """Drawn bodies in which all plans are tried, and then the best again."""
    best: int = 8
    """How many those are."""


def plans(task: Task, dream: Dream, effort: TrialBudget, rng: np.random.Generator) -> Plans:
    """Return plans that are good in the mean of what is believed."""
    aims = aim(task, dream)
    middle = sorted(effort.rhos)[len(effort.rhos) // 2]
    guesses, margins = [], []
    for margin in effort.margins:
        ground = ground_of(task, dream, aims, rho=middle, margin=margin)
        half = 0.5 * (dream.high - dream.low)
        result = _different(swung(ground, effort.rows, 4 * effort.keep, rng), half, effort.keep)
        guesses.append(result)
        margins.append(np.full(len(result.cost), margin))
    if not any(len(result.cost) for result in guesses):
        return _wandering(task, dream, rng)
    together = Trajectories(
        **{name: np.concatenate([getattr(g, name) for g in guesses]) for name in vars(guesses[0])}
    )
    paths = ddp(
        dream.plant, ground.cost, together, margin=np.concatenate(margins), most=effort.most
    )
    return with_feedback(dream, aims, paths, effort.rhos)


def _wandering(task: Task, dream: Dream, rng: np.random.Generator) -> Plans:
    """Return one plan of random commands without feedback, to see more where nothing is believed.

    It is for models in which every swing leaves all that was seen behind.
    """
    n, m, knots = 2 * dream.model.nv, dream.model.nu, task.samples
    drawn = rng.uniform(dream.low, dream.high, size=(knots // HELD + 1, m))
    command = GENTLE * np.repeat(drawn, HELD, axis=0)[:knots]
    q, v = task.start.sample(task.robot, dream.model, 1, None)
    state = np.tile(np.concatenate([q[0], v[0]]), (1, knots, 1))
    return Plans(state=state, command=command[None], gain=np.zeros((1, knots, m, n)))


def _different(guesses: Trajectories, half: Array, most: int) -> Trajectories:
    """Return the best guesses of which no two are nearly the same; they come best first."""
    kept: list[int] = []
    fine = np.isfinite(guesses.cost) & (guesses.cost <= guesses.cost.min() + HOPELESS)
    for at in np.flatnonzero(fine):
        apart = np.abs(guesses.command[kept] - guesses.command[at]) / half
        if len(kept) < most and (apart.mean(axis=(1, 2)) > APART).all():
            kept.append(int(at))
    return guesses.rows(np.array(kept, dtype=np.int64))


@dataclass(frozen=True, kw_only=True)
class Chosen:
    """The plan that promises most, of new ones and of those that were tried before."""

    plans: Plans
    """One row."""
    loss: float
    """What it should cost, over the bodies that the data allow."""
    success: float
    """In what share of them it should reach every goal."""
    tried: int | None
    """Which of those that were tried before it is, by number; None if it is new."""


def score(seen: PlanPredictions) -> Array:
    """Return what plans are compared by: their loss, and failures on top; shape (plans,)."""
    return np.asarray(seen.loss * (1.0 + FAILURE * (1.0 - seen.success)))


def chosen(
    task: Task,
    dream: Dream,
    new: Plans | None,
    tried: Plans | None,
    noise: Array,
    effort: TrialBudget,
    rng: np.random.Generator,
) -> Chosen:
    """Return the best plan over the bodies that the data allow.

    Args:
        task: The task.
        dream: The learned body.
        new: Plans that were not tried yet, if any.
        tried: Plans that were, if any.
        noise: Standard deviation of each observation, shape (2 nv,).
        effort: How many bodies to draw.
        rng: Chance.
    """
    few, many = effort.bodies
    left = []
    if new is not None:
        first = foreseen(task, dream, draw(dream.learned, few, rng), new, noise, rng)
        left.append(new.rows(np.argsort(score(first))[: effort.best].astype(np.int64)))
    fresh = len(left[0].command) if left else 0
    if tried is not None:
        left.append(tried)
    rest = joined(left)
    seen = foreseen(task, dream, draw(dream.learned, many, rng), rest, noise, rng)
    value = score(seen)
    value[fresh:] *= 1.0 - WORTHWHILE
    at = int(np.argmin(value))
    return Chosen(
        plans=rest.rows(slice(at, at + 1)),
        loss=float(seen.loss[at]),
        success=float(seen.success[at]),
        tried=None if at < fresh else at - fresh,
    )
