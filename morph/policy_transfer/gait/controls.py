"""What a carried gait is held against: wrong limbs, the order of the actuators, no source."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.policy_transfer.gait.hop import Budget, GaitBody, tuned
from morph.policy_transfer.gait.limbs import Limb

CONTROLS = ("shuffled", "flipped", "by_order", "no_source", "random")
"""What each control is called."""


def control(
    name: str, source: GaitBody, target: GaitBody, *, rng: np.random.Generator, budget: Budget
) -> GaitBody:
    """Return what the trials of a hop make of a wrong map, or of no source.

    `shuffled`: the limbs dealt out anew among the servos; `flipped`: half of the senses turned
    round by chance; `by_order`: servos in the order of the description, all of one sense;
    `no_source`: the right limbs and nothing carried; `random`: as many waves drawn by chance.
    """
    limbs = target.limbs
    if name == "shuffled":
        limbs = tuple(limbs[at] for at in rng.permutation(len(limbs)))
    elif name == "flipped":
        signs = np.where(rng.permutation(len(limbs)) % 2, -1.0, 1.0)
        limbs = tuple(
            replace(limb, sense=limb.sense * float(sign))
            for limb, sign in zip(limbs, signs, strict=True)
        )
    elif name == "by_order":
        count = len(limbs)
        limbs = tuple(
            Limb(place=(at + 1) / (count + 1), side=0.5, sense=1.0, sure=True)
            for at in range(count)
        )
    given = None if name in ("no_source", "random") else source
    explores = name == "random"
    return tuned(
        given,
        target.mover,
        limbs,
        target.late,
        0,
        rng=rng,
        trials=budget.trials,
        blind=explores,
    )
