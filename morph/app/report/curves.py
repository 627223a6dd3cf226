"""Held-out rollouts as lists of numbers that a browser plots."""

from __future__ import annotations

import math

import numpy as np

from morph.arrays import JSON, Array, Integers
from morph.model.diagnosis import Diagnosis, Trace

MOST_POINTS = 1500
"""Points drawn of one trace: more than a screen has columns."""
MOST_NUMBERS = 110_000
"""Numbers in one page, about 8 characters each, so that it stays under 2 MB beside plotly."""
MOST_TRACES = 144
"""Traces in one page; whole episodes are left out beyond it."""
BEYOND = 1.0
"""How far a plot reaches beyond the readings, in their span: a model that blew up leaves it."""


def episodes_drawn(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return the held-out episodes that fit into the page, in order."""
    names = tuple(dict.fromkeys(trace.episode for trace in diagnosis.traces))
    channels = len({trace.channel for trace in diagnosis.traces})
    return names[: max(1, MOST_TRACES // max(channels, 1))]


def curves(diagnosis: Diagnosis) -> JSON:
    """Return what the page's plots draw: episodes, channels, and the curves of each pair.

    Names are given by position, so that no name from a file reaches the scripts.
    """
    episodes = episodes_drawn(diagnosis)
    channels = tuple(dict.fromkeys(trace.channel for trace in diagnosis.traces))
    drawn = [trace for trace in diagnosis.traces if trace.episode in episodes]
    arrays = sum(2 + len(trace.models) for trace in drawn)
    limit = int(np.clip(MOST_NUMBERS // max(arrays, 1), 50, MOST_POINTS))
    models = tuple(dict.fromkeys(model for trace in drawn for model in trace.models))
    return {
        "models": len(models),
        "curves": [
            {
                "episode": episodes.index(trace.episode),
                "channel": channels.index(trace.channel),
                **_curve(trace, models, limit),
            }
            for trace in drawn
        ],
    }


def thinned(time: Array, limit: int) -> Integers:
    """Return the places of at most about `limit` readings; gaps between rollouts stay."""
    gap = ~np.isfinite(time)
    if len(time) <= limit:
        return np.arange(len(time))
    room = max(limit - int(gap.sum()), limit // 4)
    keep = gap.copy()
    keep[:: math.ceil(len(time) / room)] = True
    return np.flatnonzero(keep)


def _curve(trace: Trace, models: tuple[str, ...], limit: int) -> JSON:
    places = thinned(trace.time, limit)
    measured = trace.measured[places]
    predicted = {name: values[places] for name, values in trace.models.items()}
    values = np.concatenate([measured, *predicted.values()])
    errors = np.concatenate([p - measured for p in predicted.values()] or [np.zeros(1)])
    span = _span(measured)
    return {
        "time": _numbers(trace.time[places]),
        "measured": _numbers(measured),
        "models": [_numbers(predicted[m]) if m in predicted else None for m in models],
        "range": _within(values, span, BEYOND),
        "error_range": _within(errors, (0.0, 0.0), BEYOND * (span[1] - span[0])),
    }


def _span(values: Array) -> tuple[float, float]:
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)


def _within(values: Array, span: tuple[float, float], beyond: float) -> list[float] | None:
    """Return the ends of an axis, or None where all that is drawn fits by itself."""
    room = beyond * (span[1] - span[0]) if span[1] > span[0] else beyond
    low, high = _span(values)
    if room <= 0.0 or (low >= span[0] - room and high <= span[1] + room):
        return None
    return [max(low, span[0] - room), min(high, span[1] + room)]


def _numbers(values: Array) -> list[float | None]:
    """Return five figures of each value; what is not finite is a gap."""
    return [float(f"{v:.5g}") if math.isfinite(v) else None for v in values.tolist()]
