"""How much of a trajectory a target can track before any adjustment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array, Mask
from morph.alignment.errors import SettingError
from morph.alignment.inverse import Inverse, joint
from morph.alignment.samples import Transitions
from morph.alignment.states import change, features


@dataclass(frozen=True, kw_only=True, eq=False)
class TrackingFeasibility:
    """Which steps of a source's trajectory a target can follow, by three looks at them."""

    euclidean: Mask
    """The target was seen to make a step near this one: its start and its change, (steps,)."""
    relative: Mask
    """Near this step's start it was seen to move by nearly the same, for its size, (steps,)."""
    permitted: Mask
    """The bounds of its command permit what the inverse dynamics ask for, (steps,)."""

    @property
    def share(self) -> dict[str, float]:
        """The share of the steps, by the name of the look."""
        return {name: float(np.mean(value)) for name, value in vars(self).items()}


def following(
    source: Transitions,
    target: Transitions,
    *,
    inverse: Inverse | None = None,
    low: Array | None = None,
    high: Array | None = None,
    near: float = 0.5,
    alike: float = 0.25,
    noise: float = 0.0,
) -> TrackingFeasibility:
    """Return which steps of a source's trajectory the target can follow.

    The Euclidean look scales each feature of a state, and each number of a change, by its
    spread over both bodies' transitions; a step counts when the nearest transition of the target
    is within `near`, root mean square over these numbers. The relative look compares only
    changes: among the target's transitions that begin within `near`, the smallest
    |change - change'| / |change|, each number scaled likewise, must be at most `alike`, beside
    what noise alone makes of a difference.

    Source: Gamboa Higuera 2015, eq. 11 (the share of steps under a metric of transitions); the
    two metrics as numbers are ours.

    Args:
        source: The trajectory to follow; its commands are not looked at.
        target: What the target was seen to do.
        inverse: The target's inverse dynamics; None if only what was seen may count.
        low: Least commands, shape (nu,); None for no bound.
        high: Greatest commands, shape (nu,).
        near: See above, in spreads.
        alike: See above, a share of the change.
        noise: Standard deviation of every number of an observed state.

    Raises:
        SettingError: A threshold is not positive.
    """
    if not (near > 0.0 and alike > 0.0 and noise >= 0.0):
        raise SettingError(
            f"near is {near:g}, alike {alike:g} and the noise {noise:g}",
            where="how much of a trajectory a target can follow",
            fix="give near and alike above 0, and a noise of 0 or more",
        )
    ours, theirs = (joint(each.state, each.after, each.turns) for each in (source, target))
    spread = _spread(np.concatenate([ours, theirs]))
    begins = features(source.state, source.turns).shape[1]
    gap = (ours[:, None] - theirs) / spread
    start = np.sqrt(np.square(gap[..., :begins]).mean(axis=-1))
    whole = np.sqrt(np.square(gap).mean(axis=-1))
    moved = change(source.state, source.after, source.turns) / spread[begins:]
    # A difference of two changes holds four readings, of which each has its noise.
    chance = 2.0 * np.sqrt(np.square(noise / spread[begins:]).sum())
    differ = np.sqrt(np.square(gap[..., begins:]).sum(axis=-1))
    size = np.sqrt(np.square(moved).sum(axis=1))
    off = np.where(start <= near, differ, np.inf).min(axis=1)
    permitted = np.ones(len(ours), dtype=bool)
    if inverse is not None:
        requested, variance = inverse.predict(source.state, source.after)
        # What is not known is not forbidden: one standard deviation is left to the doubt.
        doubt = np.sqrt(variance)
        if low is not None:
            permitted &= (requested + doubt >= low).all(axis=1)
        if high is not None:
            permitted &= (requested - doubt <= high).all(axis=1)
    return TrackingFeasibility(
        euclidean=np.asarray(whole.min(axis=1) <= near),
        relative=np.asarray(off <= alike * size + chance),
        permitted=permitted,
    )


def _spread(x: Array) -> Array:
    spread = x.std(axis=0)
    return np.where(spread > 1e-9, spread, 1.0)
