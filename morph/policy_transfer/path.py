"""The way from one body to another over others, chosen by how alike bodies are for a task."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.alignment.guard import TrialTask
from morph.alignment.metric import certain, promise
from morph.errors import TransferError
from morph.policy_transfer.body import Body, linear_law
from morph.policy_transfer.mapped.belief import read
from morph.policy_transfer.relay import carry, nearest_path

LOOKS = 5
"""Transitions of the described target that a hop to it is tried with: with many the source would no
longer matter."""

STARTS = 4
"""Starts from which a policy is foreseen to run."""

UNSEEN = 1e-4
"""Noise of a reading in a description, which is certain."""


def path(bodies: Sequence[Body], *, most: int, seed: int = 0) -> tuple[Body, ...]:
    """Return the chain from the first body to the last whose worst hop promises most.

    Only descriptions are looked at: what a hop from each body promises on each other one.

    Source: Gamboa Higuera 2015, section 4.1 (a metric that chooses the source).

    Args:
        bodies: From which, over which, and last to which; two or more.
        most: Most hops.
        seed: Of the transitions that the descriptions are asked for.

    Raises:
        TransferError: There are fewer than two bodies, or no hop is allowed.
    """
    if len(bodies) < 2 or most < 1:
        raise TransferError(
            f"it has {len(bodies)} bodies and {most} hops",
            where="a path from body to body",
            fix="give two bodies or more, and one hop or more",
        )
    way = nearest_path(bodies, lambda a, b: apart(a, b, seed=seed), most=most)
    return tuple(bodies[at] for at in way)


def apart(source: Body, target: Body, *, seed: int = 0) -> float:
    """Return how far a target is from a source, 0 to 2: one less what a hop promises there.

    The hop is made to the described target, with few transitions, and foreseen on its linear
    model. It is no distance: there and back may differ.

    Args:
        source: Whose policy would be carried, by its description.
        target: To which, by its description.
        seed: Of the transitions that the descriptions are asked for.
    """
    rng = np.random.default_rng([seed, 19])
    hopped, _ = carry(source, target, LOOKS, seed=seed)
    task, model = target.task, target.plant.model
    q, v = task.start.sample(task.robot, model, STARTS, rng)
    low, high = target.bounds
    trial = TrialTask(
        outcome=target.outcome,
        starts=target.seen(target.state(q, v)),
        low=low,
        high=high,
        periods=task.samples - 1,
        period=task.period,
    )
    known = certain(read(target), noise=np.full(target.size, UNSEEN))
    return 1.0 - promise(known, linear_law(hopped.gain), trial, rng, draws=1)
