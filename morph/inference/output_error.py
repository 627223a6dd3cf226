"""Figures refitted to the error of rollouts, for models that miss more than noise."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import Array
from morph.inference.finalist import Finalist
from morph.inference.validate import HORIZON, Validation
from morph.model.episodes import Episode
from morph.model.fit import fit, measure
from morph.model.segments import cut
from morph.model.shooting import predict

MOST_ROLLOUTS = 48
"""Most rollouts that are fitted; of longer recordings an even spread."""
STEPS = 4
"""Most Gauss-Newton steps."""


def output_error_point(found: Finalist, validation: Validation, train: Sequence[Episode]) -> Array:
    """Return a model's point refitted by multiple shooting, unless rollouts are surely worse.

    They are as long as those that models are compared by: longer ones of a swinging arm diverge,
    and their figures then are no longer physical.

    The whitened likelihood is efficient where the model of the disturbance is right. Where physics
    without a name remains it is not, and a fit of what is scored predicts better.

    Args:
        found: The model.
        validation: Stretches on which both points are compared.
        train: The runs.
    """
    hypothesis, point, runs = found.refit.hypothesis, found.refit.point, found.refit.runs
    longest = min(len(e.command) for e in train) * train[0].step
    segments = cut(train, min(HORIZON, 0.5 * longest), most=MOST_ROLLOUTS)
    read = predict(hypothesis, segments, [point], [segments.start])[0]
    units = measure(segments, read)
    refitted = fit(hypothesis, segments, *units, point=point, iterations=STEPS).point

    def losses(at: Array) -> Array:
        points = [at] * (int(validation.fold.max()) + 1)
        return np.asarray(validation.losses(hypothesis, [points], runs)[0])

    return point if validation.worse(losses(point), losses(refitted)) else refitted
