"""Recommend what to try next on a target, given all trials so far."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from morph.errors import MorphError
from morph.model.kwik.certify import ModelVerdict
from morph.policy.policy import Policy
from morph.policy_transfer.adjustment.adjust import adjusted
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.policy_transfer.gate import gated
from morph.policy_transfer.predicted_return import PredictedReturn, foresee
from morph.policy_transfer.repair import Repair, TaskModel, repaired
from morph.policy_transfer.trial_record import TrialRecord
from morph.search.plan.replan import ReplanBudget, again
from morph.task.task import Task

DRAWS = 3
"""Models drawn beside the most probable one, in which policies are judged."""

WORTH = 0.05
"""Share of the loss that another policy must promise to save before it is tried."""

STAGES = (
    ReplanBudget(recalled=48, rows=512, keep=4, most=15, runs=24),
    ReplanBudget(recalled=0, rows=768, keep=4, most=20, runs=32, share=0.65),
    ReplanBudget(recalled=48, rows=1536, keep=6, most=20, runs=32, share=0.8),
)
"""What a search spends, stage after stage while no plan succeeds: the first is already wide, as the
first plan that succeeds may still cost half as much again as the best."""

Said = Callable[[str], None]


@dataclass(frozen=True, kw_only=True, eq=False)
class NextAction:
    """What to try next, and why."""

    verdict: ModelVerdict
    """Whether the model by which the last policy was made was good enough for its trial."""
    repair: Repair
    """The model as all trials say it should be."""
    policy: Policy
    """What to try, or to keep."""
    origin: str
    """Where it comes from."""
    foreseen: PredictedReturn
    """What it promises on the target as it is known now."""
    known: PredictedReturn
    """What the best policy that was already tried promises."""
    searched: bool = False
    """Whether another policy was adjusted or searched, whatever came of it."""


def advise(
    task: Task,
    tried: Sequence[TrialRecord],
    *,
    before: TaskModel | None = None,
    seed: int,
    more: bool = True,
    statement: Said = lambda _: None,
) -> NextAction:
    """Return the policy that promises most on a target.

    The gate says whether the model was good enough for the last trial. The source's simulation
    is repaired by what all trials showed. If the model was good enough, the last policy is
    adjusted, else one is searched in the repaired simulation, from the best one on; and all are
    judged in it and in others that the trials allow as well, so that a policy that promises no
    more than one tried before is not tried.

    Source: Gamboa Higuera 2015, section 3.4: adjust if the model is good enough, else update it.

    Args:
        task: The source's task.
        tried: Every trial so far, the first with the source's policy.
        before: The model by which the last policy was made; None for the source's own.
        seed: Of the search and of the chance in judging.
        more: Whether another trial can be made; otherwise the best of those made is advised.
        statement: Is told what is going on.

    Raises:
        DiagnosisError: The body floats, or a trial does not fit the task.
    """
    last = tried[-1]
    model = before or TaskModel(task=task, effects=())
    statement("asking whether the model is good enough")
    verdict = gated(model, last.experience.run, task, seed=seed)
    statement("repairing the model")
    repair = repaired(task, [each.experience.run for each in tried], progress=statement)
    models = (repair.model, *repair.drawn(DRAWS, np.random.default_rng([seed, 1])))
    known = foresee([each.policy for each in tried], models, seed=seed)
    best = int(np.argmin([each.score for each in known]))
    if not more or (verdict.verdict == "good" and last.experience.success):
        return _advice(verdict, repair, tried[best].policy, tried[best].origin, known[best])
    if verdict.verdict == "good":
        statement("adjusting the policy")
        result, origin = adjusted_policy(model, last, seed=seed), "adjusted"
    else:
        statement("searching a policy in the repaired model")
        result, origin = searched(models, tried[best].policy, seed=seed), "searched again"
    if result is not None:
        (promised,) = foresee([result], models, seed=seed)
        if promised.score < (1.0 - WORTH) * known[best].score:
            advice = _advice(verdict, repair, result, origin, known[best], promised)
            return replace(advice, searched=True)
    advice = _advice(verdict, repair, tried[best].policy, tried[best].origin, known[best])
    return replace(advice, searched=True)


def _advice(
    verdict: ModelVerdict,
    repair: Repair,
    policy: Policy,
    origin: str,
    known: PredictedReturn,
    foreseen: PredictedReturn | None = None,
) -> NextAction:
    return NextAction(
        verdict=verdict,
        repair=repair,
        policy=policy,
        origin=origin,
        foreseen=foreseen or known,
        known=known,
    )


def adjusted_policy(model: TaskModel, last: TrialRecord, *, seed: int) -> Policy | None:
    """Return the last policy adjusted to the target, or None if it cannot be adjusted."""
    try:
        source = SimulatedTask(task=model.task, simulator=model.simulator)
        rng = np.random.default_rng([seed, 4])
        return adjusted(source, last.policy, [last.experience], rng=rng).policy
    except MorphError:
        return None


def searched(models: Sequence[TaskModel], old: Policy, *, seed: int) -> Policy | None:
    """Return a policy for the first of some models that does in the others too.

    It begins from an old policy; None if none can be searched.
    """
    first, *others = models
    try:
        return again(
            first.task,
            first.simulator,
            old,
            seed=seed,
            others=[each.simulator for each in others],
            stages=STAGES,
        ).policy
    except MorphError:
        # Whatever hinders a search: a policy that was tried is still there.
        return None
