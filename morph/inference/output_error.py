"""Refit to the errors of rollouts, for models that miss more than noise."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.inference.quadratic import LogPosterior
from morph.inference.validate import Validation
from morph.model.deadline import NEVER, Deadline
from morph.model.fit import fit, measure
from morph.model.hypothesis import Hypothesis
from morph.model.shooting import predict, quadratic, sensitivity

SCALINGS, STEPS = 3, 4
"""Most estimates of the errors' sizes, and steps under each."""
MOST_FITTED = 30
"""Most stretches that are fitted, an even spread of those by which sets are compared."""
FALLEN = 0.02
"""Logarithm of the factor by which errors must fall for another estimate of their sizes."""


def output_error(
    hypothesis: Hypothesis,
    point: Array,
    validation: Validation,
    deadline: Deadline = NEVER,
) -> LogPosterior:
    """Return the log posterior about the point at which rollouts err least, by multiple shooting.

    The slope that the last step leaves is taken from all folds evenly, so that points without one
    fold scatter about the point. At bounds it stays.

    The whitened likelihood is efficient where the model of the disturbance is right. Where physics
    without a name remains it is not: readings of a geared joint that sticks are likeliest where
    the joint sticks for any reason, such as a weak motor. A fit of what is scored predicts better.

    Source: Maine and Iliff 1985, NASA Reference Publication 1138, section 2 (output error beside
    filter error).

    Args:
        hypothesis: Own parameters and effects.
        point: Where it begins, shape (entries,).
        validation: The rollouts, and which fold each belongs to.
        deadline: After which no step begins.
    """
    some = min(len(validation.segments), MOST_FITTED)
    rows = np.linspace(0, len(validation.segments) - 1, some).round().astype(int)
    segments = validation.segments.only(rows)
    read = predict(hypothesis, segments, [point], [segments.start])[0]
    units = measure(segments, read)
    result = fit(hypothesis, segments, *units, point=point, iterations=STEPS, deadline=deadline)
    for _ in range(SCALINGS - 1):
        read = segments.reading - result.around.error.reshape(read.shape) * result.scale
        scale, weight = measure(segments, read)
        if float(np.log(scale / result.scale).mean()) > -FALLEN:
            break
        # Errors that have fallen weigh more beside the prior.
        result = fit(
            hypothesis,
            segments,
            scale,
            weight,
            point=result.point,
            start=result.start,
            around=result.around.in_units(result.scale / scale),
            iterations=STEPS,
            deadline=deadline,
        )
    point, around = result.point, result.around
    if not around.exact and not deadline.passed:
        around = sensitivity(hypothesis, segments, point, result.start, result.scale)
    fold, curve = validation.fold[rows], quadratic(segments, around, result.weight)
    grams = np.zeros((validation.folds, 1 + len(point), 1 + len(point)))
    np.add.at(grams[:, 0, 0], fold, curve.loss)
    np.add.at(grams[:, 0, 1:], fold, curve.slope)
    np.add.at(grams[:, 1:, 0], fold, curve.slope)
    np.add.at(grams[:, 1:, 1:], fold, curve.hessian)
    about = LogPosterior(
        hypothesis=hypothesis,
        point=point,
        grams=grams,
        readings=len(segments) * segments.reading.shape[2],
    )
    # What slope is left is taken from the folds evenly.
    left = about.along()
    held = np.where(left > 0.0, point >= hypothesis.high, point <= hypothesis.low)
    share = np.bincount(fold, minlength=validation.folds) / len(fold)
    even = share[:, None] * np.where(held, 0.0, left)
    grams[:, 1:, 0] -= even
    grams[:, 0, 1:] -= even
    return about
