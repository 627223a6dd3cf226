"""What to try next on a target, by all that was tried on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from morph.errors import SearchError
from morph.policy.policy import Policy
from morph.search.ddp import Plan
from morph.search.search import Problem
from morph.task.task import Task
from morph.transfer.foresee import Foreseen, foresee
from morph.transfer.repair import Model, Repair, repaired
from morph.transfer.tried import Tried

DRAWS = 3
"""Models drawn beside the most probable one, in which policies are judged."""

WORTH = 0.05
"""Share of the loss that another policy must promise to save before it is tried."""

Said = Callable[[str], None]


@dataclass(frozen=True, kw_only=True, eq=False)
class Advice:
    """What to try next, and why."""

    policy: Policy
    """What to try."""
    origin: str
    """Where it comes from."""
    foreseen: Foreseen
    """What it promises on the target as it is known now."""
    repair: Repair
    """The repaired model."""
    known: Foreseen
    """What the best policy that was already tried promises."""


def advise(task: Task, tried: Sequence[Tried], *, seed: int, said: Said = lambda _: None) -> Advice:
    """Return the policy that promises most on a target.

    The source's simulation is repaired by what the trials showed, a policy is searched in it
    from the latest one on, and all policies are judged in it and in others that the trials allow
    as well; so a policy that does no better than one tried before is not tried.

    Args:
        task: The source's task.
        tried: Every trial so far, the first with the source's policy.
        seed: Of the search and of the chance in judging.
        said: Is told what is going on.

    Raises:
        DiagnosisError: The body floats, or a trial does not fit the task.
    """
    said("repairing the model")
    repair = repaired(task, [each.experience.run for each in tried], told=said)
    models = (repair.model, *repair.drawn(DRAWS, np.random.default_rng([seed, 1])))
    policies = [each.policy for each in tried]
    origins = [each.origin for each in tried]
    before = foresee(policies, models, seed=seed)
    best = int(np.argmin([each.score for each in before]))
    said("searching a policy in the repaired model")
    found = searched(repair.model, policies[best], seed=seed)
    if found is not None:
        (promised,) = foresee([found], models, seed=seed)
        if promised.score < (1.0 - WORTH) * before[best].score:
            return Advice(
                policy=found,
                origin="searched again",
                foreseen=promised,
                repair=repair,
                known=before[best],
            )
    return Advice(
        policy=policies[best],
        origin=origins[best],
        foreseen=before[best],
        repair=repair,
        known=before[best],
    )


def searched(model: Model, old: Policy, *, seed: int) -> Policy | None:
    """Return a policy for a model, or None if none can be searched in it."""
    try:
        problem = Problem(task=model.task, simulator=model.simulator)
        return Plan().run(problem, seed=seed).policy
    except SearchError:
        return None
