"""The guard on a body that balances: whether a law may be tried on it."""

from __future__ import annotations

import numpy as np

from morph.alignment.belief import Belief, believed, mechanical
from morph.alignment.guard import TrialTask, foreseen, judge
from morph.alignment.samples import Transitions
from morph.policy_transfer.body import Body, Law
from morph.policy_transfer.transfer_record import GuardRecord

STARTS = 4
"""Starts from which every body that is thought possible is run."""

LEAST = 1e-6
"""Noise of a reading that is taken for certain."""


def guarded(body: Body, seen: Transitions, law: Law, rng: np.random.Generator) -> GuardRecord:
    """Return the guard's verdict on a law from a few transitions of a body; it runs nothing there.

    Its probability is that the law does no harm: that it scores no less than holding still.

    Raises:
        SamplesError: The transitions tell nothing.
    """
    task, model = body.task, body.plant.model
    q, v = task.start.sample(task.robot, model, STARTS, rng)
    low, high = body.bounds
    trial = TrialTask(
        outcome=body.outcome,
        starts=body.seen(body.state(q, v)),
        low=low,
        high=high,
        periods=round(task.horizon / task.period),
        period=task.period,
    )
    belief = belief_of(body, seen)
    verdict = judge(foreseen(belief, law, trial, rng))
    return GuardRecord(verdict=verdict.verdict, probability=1.0 - verdict.probability)


def belief_of(body: Body, seen: Transitions) -> Belief:
    """Return what transitions of a body tell about how it moves near rest.

    Raises:
        SamplesError: They tell nothing.
    """
    low, high = body.bounds
    # Of a servo whose joint may turn without end a whole command is half a turn.
    half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    base, lift, wide = mechanical(body.size // 2, half, body.task.period)
    noise = np.full(body.size, max(body.task.noise, LEAST))
    return believed(seen, noise=noise, base=base, lift=lift, wide=wide)
