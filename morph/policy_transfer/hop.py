"""A hop: the policy of one body that balances, carried to another by a learned map."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from morph.alignment.guard import Verdict
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import BodyMap
from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.errors import TransferError
from morph.policy_transfer.body import Body, linear_law
from morph.policy_transfer.mapped.belief import carried, learned
from morph.policy_transfer.mapped.feedback import cautious, chosen, holding, plain
from morph.policy_transfer.mapped.lift import lift, quality_of


@dataclass(frozen=True, kw_only=True, eq=False)
class Hopped:
    """What one hop gave: a map, feedback for the target, and what they are worth."""

    source: str
    """The body that the policy is of."""
    target: str
    """The body that it was carried to."""
    map: BodyMap
    """How states of the target are seen as the source's, and commands go back."""
    quality: Mapping[str, float]
    """Of the map: `round_trip` and `dynamics`, 1 at best."""
    guard: Verdict | None
    """What was foreseen before any run on the target; None if nobody asked."""
    samples: int
    """Transitions of the target that were used."""
    gain: Array
    """Feedback of the target about rest, u = gain x + shift, shape (nu, n)."""
    shift: Array
    """Shape (nu,)."""
    scores: Mapping[str, float] = field(default_factory=dict)
    """Scores on the target that were measured, 0 to 1, by what ran."""


def hop(
    source: Body,
    target: Body,
    seen: Transitions,
    *,
    seed: int,
    source_gain: Array | None = None,
    seen_as: AffineMap | None = None,
    rows: int = 0,
) -> Hopped:
    """Return the feedback of a target from that of a source and a few transitions.

    The six steps: the source's policy and simulator; transitions of the target; a map between
    them, learned; the source's dynamics seen through the map as what is believed of the target
    beforehand; the transitions correct the belief; the policy is made anew on what is believed.

    Told of the target: its transitions, the noise and the period, the bounds of its commands and
    which numbers its task looks at. Its true model is never looked at.

    Source: Gamboa Higuera 2015, section 3.3, eqs. 8 and 12.

    Args:
        source: The body that can balance; its simulator is ours to use.
        target: The body that shall.
        seen: Transitions of the target.
        seed: Of the runs that score it.
        source_gain: The source's feedback, shape (nu_s, n_s); made from its model if none.
        seen_as: A map that is known already; learned from the transitions if none.
        rows: Runs of the target by which to score; none if 0.

    Raises:
        TransferError: The transitions are not the target's.
    """
    if seen.state.shape[1] != target.size:
        raise TransferError(
            f"a state of the transitions has {seen.state.shape[1]} numbers and of the target "
            f"{target.size}",
            where=f"a hop to {target.task.robot.name}",
            fix="give transitions of the target",
        )
    gain = holding(source) if source_gain is None else source_gain
    if seen_as is None:
        seen_as = lift(source, target, seen)
    believed = learned(seen, carried(source, seen_as, target), target)
    through = through_map(seen_as, gain, target)
    choices = {
        "cautious": cautious(believed, target),
        "map_only": through,
        "plain": plain(believed.step, target),
    }
    _, result = chosen(choices, believed, target, np.random.default_rng(seed))
    scores = {}
    if rows:
        scores["zero_shot"] = target.score(linear_law(result), rows=rows, seed=seed)
        scores["map_only"] = target.score(linear_law(through), rows=rows, seed=seed)
    return Hopped(
        source=source.task.robot.name,
        target=target.task.robot.name,
        map=seen_as,
        quality=quality_of(seen_as, source, seen),
        guard=None,
        samples=len(seen.state),
        gain=result,
        shift=np.zeros(len(result)),
        scores=scores,
    )


def through_map(seen_as: BodyMap, gain: Array, target: Body) -> Array:
    """Return the source's feedback seen through a map, about the target's rest."""
    y = np.concatenate([np.zeros((1, target.size)), np.eye(target.size)])
    command = seen_as.action(y, seen_as.state(y) @ gain.T)
    return np.asarray((command[1:] - command[0]).T)
