"""The worst moments: stretches in which the description is furthest from the recording."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.app.viewer.mismatch.rollouts import simulated
from morph.app.viewer.mismatch.window import DESCRIBED, MismatchModel, MismatchTrace, Take
from morph.model.episodes import Episode
from morph.model.score import by_segment

WORST = 3
"""Stretches that are marked."""
STRETCH = 1.0
"""Seconds of a stretch, where no diagnosis says how long they are."""


def worst_stretches(
    model: MismatchModel, episode: Episode, horizon: float
) -> tuple[tuple[float, float], ...]:
    """Return the stretches that a model misses most, each joint in units of its noise."""
    segments, predicted = simulated([model], episode, horizon)
    lost = by_segment(segments, predicted[model.name], segments.noise)
    order = np.argsort(-lost)[:WORST]
    return tuple(segments.seconds(int(row)) for row in order if lost[row] > 0.0)


def worst_of(traces: Sequence[MismatchTrace], seconds: float) -> tuple[tuple[float, float], ...]:
    """Return the worst stretches of channels that were simulated, each in units of its noise."""
    edges = np.arange(0.0, max(seconds, STRETCH) + 1e-9, STRETCH)
    lost = np.zeros(len(edges) - 1)
    for trace in traces:
        error = (trace.measured - trace.simulated[DESCRIBED]) / trace.noise
        known = np.isfinite(trace.time) & np.isfinite(error)
        lost += np.histogram(trace.time[known], edges, weights=error[known] ** 2)[0]
    order = [int(at) for at in np.argsort(-lost)[:WORST] if lost[at] > 0.0]
    return tuple((float(edges[at]), float(min(edges[at + 1], seconds))) for at in order)


def worst_trace(take: Take, begin: float, end: float) -> MismatchTrace:
    """Return the channel that the description misses most in a stretch, in units of its noise."""

    def lost(trace: MismatchTrace) -> float:
        here = (trace.time >= begin) & (trace.time <= end)
        error = (trace.measured - trace.simulated[DESCRIBED])[here] / trace.noise
        return float(np.mean(error**2)) if len(error) else 0.0

    return max(take.traces, key=lost)
