"""Sets of effects simulated over the stretches before any is refitted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from morph.inference.dictionary import dictionary
from morph.inference.finalist import Finalist
from morph.inference.search import Explanation, Search
from morph.inference.validate import MATERIAL, Validation
from morph.physics.actuator.limit import LimitEffect
from morph.physics.effect import Effect


def simulated(found: Explanation, search: Search, base: Finalist, validation: Validation) -> float:
    """Return the mean loss of a set that is added to another.

    Each stretch is simulated with the figures fitted to the other folds.

    Args:
        found: The effects to add.
        search: What they come from.
        base: The other set.
        validation: The stretches.
    """
    hypothesis, there, points = base.refit.hypothesis, len(base.refit.point), []
    for fold in range(validation.folds):
        change, effects = search.without_fold(found, fold)
        more = replace(hypothesis, effects=(*hypothesis.effects, *effects))
        point = np.r_[base.refit.point + change, more.start[there:]]
        points.append(np.clip(point, more.low, more.high))
    more = replace(hypothesis, effects=(*hypothesis.effects, *found.effects))
    return float(validation.losses(more, [points], base.refit.runs).mean())


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
