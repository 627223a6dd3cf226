"""Links that are off all at once: what each weighs, chosen together by linear algebra.

A body that was printed differs from its description in every link. One link alone explains
little of that, and a spring or a sensor somewhere may explain more; all of them together
explain it, and one linear system says how.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.model.crossvalidate import MATERIAL
from morph.model.fit import Fit, measure
from morph.model.hypothesis import Hypothesis, same_kind
from morph.model.segments import Segments
from morph.model.shooting import Sensitivity, predict, quadratic, residual
from morph.model.subset import Subset
from morph.physics.body.com_offset import ComOffset
from morph.physics.body.link_inertia import LinkInertia
from morph.physics.effect import Effect

KINDS: tuple[type[Effect], ...] = (LinkInertia, ComOffset)
"""What a link may differ in, the first to be believed first.

Where gravity alone is felt, a mass that is off and a centre that is off are told by one number:
a centre is said to be off only where masses do not explain what is seen."""


@dataclass(frozen=True, kw_only=True)
class Together:
    """A model with effects on many links, everything chosen to first order."""

    hypothesis: Hypothesis
    """The model, its effects as chosen."""
    point: Array
    """Its entries as chosen."""
    cost: float
    """Loss of all segments and price of straying, to first order."""


def together(found: Fit, segments: Segments) -> Together | None:
    """Return a fitted model with what its links weigh let free, less what does not matter.

    One rollout for each mass, inertia and coordinate of a centre tells how it moves the
    readings; the quadratic about the fit then says what all of them together would explain,
    and which of them that needs. Each is drawn to neutral by how far it is likely to be from
    there: of what the motion cannot tell apart, the least is changed.

    Source: Atkeson, An and Hollerbach 1986, Int. J. Robotics Research 5(3): dynamics are linear
    in the inertial parameters, and only some combinations of them show.

    Args:
        found: The fit without them.
        segments: What it was fitted to.

    Returns:
        The model; None if one effect alone would do almost as well.
    """
    if len(_every(found.hypothesis)) < 2:
        return None
    coarse, around = _subset(found, segments)
    # Large errors hide small ones: what is left if all matter is the unit of what matters.
    scale, weight = measure(segments, _foreseen(coarse, around, found, segments))
    finer = around.in_units(found.scale / scale)
    fine = replace(coarse, quadratic=quadratic(segments, finer, weight))
    kept = _needed(fine)
    if len(kept) < 2:
        return None
    alone = min(fine.solved([index])[1] for index in fine.questioned)
    spared = min(MATERIAL * (len(kept) - 1), 0.5)
    promising = fine.solved(kept)[1] < (1.0 - spared) * alone
    return _chosen(fine, coarse, kept) if promising else None


def instead(
    found: Fit, segments: Segments, grouped: set[str]
) -> dict[str, list[tuple[Effect, float]]]:
    """Return what else could be said of each link in a fit, and how probable that is.

    Args:
        found: The fit.
        segments: What it was fitted to.
        grouped: Labels of the effects that were found together.
    """
    subset, _ = _subset(found, segments)
    effects = subset.hypothesis.effects
    fixed = [i for i, effect in enumerate(effects[: subset.had]) if effect.label not in grouped]
    kept = [i for i in range(subset.had) if i not in fixed]
    # The fit's own effects come first; those of links are in question again.
    order = [*fixed, *kept, *range(subset.had, len(effects))]
    subset = _reordered(subset, order, len(fixed))
    effects, kept = subset.hypothesis.effects, list(range(len(fixed), len(fixed) + len(kept)))
    price, said = subset.priced(kept), {}
    for index in kept:
        others = [
            other
            for other in subset.questioned
            if other not in kept and effects[other].where == effects[index].where
        ]
        swapped = [[other, *(each for each in kept if each != index)] for other in others]
        worse = np.array([subset.priced(each) - price for each in swapped])
        odds = np.exp(-0.5 * np.clip(worse, -60.0, 60.0))
        said[effects[index].label] = [
            (effects[other], float(share))
            for other, share in zip(others, odds / (1.0 + odds.sum()), strict=True)
        ]
    return said


def _subset(found: Fit, segments: Segments) -> tuple[Subset, Sensitivity]:
    """Return the quadratic about a fit with every link's effects that it lacks, and its slopes."""
    had = found.hypothesis.effects_at(found.point)
    more = replace(found.hypothesis, effects=(*had, *_every(found.hypothesis)))
    point = np.concatenate([found.point, more.start[found.hypothesis.size :]])
    around = _beside(found, segments, more, point)
    curve = quadratic(segments, around, found.weight)
    return Subset(hypothesis=more, had=len(had), point=point, quadratic=curve), around


def _reordered(subset: Subset, order: list[int], had: int) -> Subset:
    """Return a quadratic with its effects in another order."""
    effects, at = subset.hypothesis.effects, len(subset.hypothesis.knobs)
    ends = at + np.cumsum([0, *(len(effect.free()) for effect in effects)])
    entries = np.concatenate(
        [np.arange(at), *(np.arange(ends[index], ends[index + 1]) for index in order)]
    )
    curve = subset.quadratic
    return Subset(
        hypothesis=replace(subset.hypothesis, effects=tuple(effects[index] for index in order)),
        had=had,
        point=subset.point[entries],
        quadratic=replace(
            curve,
            hessian=curve.hessian[:, entries][:, :, entries],
            slope=curve.slope[:, entries],
            start_slope=curve.start_slope[:, :, entries],
        ),
    )


def _every(hypothesis: Hypothesis) -> tuple[Effect, ...]:
    return tuple(
        kind.at(link)
        for kind in KINDS
        for link in kind.suspects(hypothesis.robot)
        if not any(same_kind(kind.at(link), had) for had in hypothesis.effects)
    )


def _needed(subset: Subset) -> list[int]:
    """Return the effects in question that matter: masses, then what masses do not explain."""
    effects = subset.hypothesis.effects
    masses = [i for i in subset.questioned if isinstance(effects[i], KINDS[0])]
    return subset.with_material(subset.without_idle(masses))


def _beside(found: Fit, segments: Segments, more: Hypothesis, point: Array) -> Sensitivity:
    """Return a fit's derivatives with those of more effects beside them."""
    own = found.hypothesis.size
    if more.size == own:
        return found.around
    # A fifth of what is likely: so far the readings' change is as good as straight.
    nudge = 0.2 / np.sqrt(more.trust[own:])
    points = [point + step * np.eye(more.size)[own + i] for i, step in enumerate(nudge)]
    read = predict(more, segments, points, [found.start] * len(points))
    flat = residual(segments, read, found.scale).reshape(len(points), len(segments), -1)
    change = np.moveaxis(found.around.error - flat, 0, -1) / nudge
    return replace(found.around, by_point=np.concatenate([found.around.by_point, change], axis=2))


def _foreseen(subset: Subset, around: Sensitivity, found: Fit, segments: Segments) -> Array:
    """Return what a model with all effects would read, (segments, readings, joints)."""
    change = subset.solved(subset.questioned)[0]
    start = subset.quadratic.starts_after(around.start, change) - around.start
    error = around.error - around.by_point @ change
    error = error - np.einsum("srj,sj->sr", around.by_start, start)
    return np.asarray(segments.reading - error.reshape(segments.reading.shape) * found.scale)


def _chosen(fine: Subset, coarse: Subset, kept: list[int]) -> Together:
    """Return the model with the effects that are kept."""
    more, had = fine.hypothesis, fine.had
    moved = np.clip(fine.point + fine.solved(kept)[0], more.low, more.high)
    effects = more.effects_at(moved)
    fewer = replace(more, effects=(*effects[:had], *(effects[index] for index in kept)))
    known = len(fewer.knobs)
    return Together(
        hypothesis=fewer,
        point=np.concatenate([moved[:known], fewer.start[known:]]),
        cost=coarse.solved(kept)[1],
    )
