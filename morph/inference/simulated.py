"""Sets of effects simulated over the stretches before any is refitted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from morph.inference.dictionary import dictionary
from morph.inference.finalist import Finalist
from morph.inference.search import BeamSearch, Explanation
from morph.inference.validate import MATERIAL, Validation
from morph.physics.actuator.limit import LimitEffect
from morph.physics.effect import Effect

STRENGTHS = (1.0, 0.3, 0.1)
"""Shares of linearised strengths that are simulated where the linearisation is not believed."""

SENSED = (-0.01, 0.01)
"""Changes of a sensor that are simulated: s of its clock, rad or m of its zero, a share of its
scale."""


def simulated(
    result: Explanation,
    search: BeamSearch,
    base: Finalist,
    validation: Validation,
    *,
    believed: bool,
    enough: float = math.inf,
) -> tuple[float, Explanation]:
    """Return the mean loss of a set that is added to another, and the set as it is simulated.

    Args:
        result: The effects to add.
        search: What they come from.
        base: The other set.
        validation: The stretches.
        believed: Whether the linearisation is. If so, each stretch is simulated with the figures
            fitted to the other folds. If not, own parameters stay where they are, and the best of a
            few shares of the strengths is taken.
        enough: Loss above which a believed linearisation is no more: what forces say of own
            parameters need not hold in rollouts.
    """
    hypothesis, there = base.refit.hypothesis, len(base.refit.point)
    parts = [(result.own, result.effects)] * validation.folds
    if believed:
        parts = [search.without_fold(result, fold) for fold in range(validation.folds)]
    points, more = [], hypothesis
    for share in STRENGTHS[:1] if believed else STRENGTHS:
        weaker = [(*hypothesis.effects, *scaled(effects, share)) for _, effects in parts]
        more = replace(hypothesis, effects=weaker[0])
        starts = [replace(more, effects=effects).start[there:] for effects in weaker]
        own = [base.refit.point + (change if believed else 0.0) for change, _ in parts]
        points.append(
            [np.clip(np.r_[o, s], more.low, more.high) for o, s in zip(own, starts, strict=True)]
        )
    losses = validation.losses(more, points, base.refit.runs).mean(axis=1)
    best = int(np.argmin(losses))
    found = replace(result, effects=scaled(result.effects, STRENGTHS[best]))
    if believed and losses[best] > enough:
        held = replace(result, own=np.zeros_like(result.own))
        other = simulated(held, search, base, validation, believed=False)
        return min((float(losses[best]), found), other, key=lambda one: one[0])
    return float(losses[best]), found


def likeliest_limit(
    base: Finalist, validation: Validation, now: float, known: Sequence[Effect]
) -> tuple[float, Explanation] | None:
    """Return the limit of a servo beside a set with which rollouts err least, and their mean loss.

    Where a servo cannot follow, the torque that it seems to lack is its gain times an error that
    its limit lets grow: no column in proportion to a strength tells of it. Constant limits of all
    servos are simulated at all shapes; lines over speed, of the servo of which one of them gains
    most. What a motor driven by torque lacks, columns tell.

    Args:
        base: A set of effects.
        validation: The stretches that are simulated.
        now: Mean loss of the set over them.
        known: Effects whose fixed parameters are known.

    Returns:
        None if no limit gains anything.
    """
    hypothesis, runs, own = base.refit.hypothesis, base.refit.runs, base.refit.point
    taken = {effect.label for effect in base.effects}
    servos = {each.name for each in hypothesis.robot.actuators if each.kind == "position"}
    grids = [
        [each for each in grid if isinstance(each, LimitEffect)]
        for grid in dictionary(hypothesis.robot, runs, known)
    ]
    grids = [grid for grid in grids if grid and grid[0].where in servos]
    least, best = now - MATERIAL, None
    # A line over speed is a constant limit's richer law.
    for limits in sorted(grids, key=lambda grid: bool(grid[0].simpler)):
        first = limits[0]
        promising = not first.simpler or (best is not None and best.where == first.where)
        if first.label in taken or not promising:
            continue
        sets = [replace(hypothesis, effects=(*hypothesis.effects, limit)) for limit in limits]
        points = [np.r_[own, each.start[len(own) :]] for each in sets]
        candidates = [[point] * validation.folds for point in points]
        losses = validation.losses(sets[0], candidates, runs).mean(axis=1)
        if losses.min() < least:
            least, best = float(losses.min()), limits[int(losses.argmin())]
    if best is None:
        return None
    change = np.zeros(len(own))
    return least, Explanation(effects=(best,), gain=0.0, own=change, members=(), level=0)


def likeliest_sensor(
    base: Finalist, validation: Validation, known: Sequence[Effect]
) -> Effect | None:
    """Return the law of a sensor beside a set with which rollouts err least; none if none gains.

    Args:
        base: A set of effects.
        validation: The stretches that are simulated.
        known: Effects whose fixed parameters are known.
    """
    hypothesis, runs, own = base.refit.hypothesis, base.refit.runs, base.refit.point
    taken, best = {effect.label for effect in base.effects}, None
    least = float(base.losses.mean()) - MATERIAL
    for grid in dictionary(hypothesis.robot, runs, known):
        if grid[0].kind != "sensor" or grid[0].label in taken:
            continue
        laws = [grid[0].with_strengths(np.array([change])) for change in SENSED]
        sets = [replace(hypothesis, effects=(*hypothesis.effects, law)) for law in laws]
        points = [[np.r_[own, each.start[len(own) :]]] * validation.folds for each in sets]
        losses = validation.losses(sets[0], points, runs).mean(axis=1)
        at = int(losses.argmin())
        if losses[at] < least:
            least, best = float(losses[at]), laws[at]
    return best


def scaled(effects: Sequence[Effect], share: float) -> tuple[Effect, ...]:
    """Return effects at a share of their strengths."""
    if share == 1.0:
        return tuple(effects)
    return tuple(each.with_strengths(share * each.coefficients) for each in effects)
