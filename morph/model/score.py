"""Errors of models on recordings that they never saw."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from morph.arrays import Array, Integers
from morph.model.diagnosis import Trace
from morph.model.hypothesis import Hypothesis
from morph.model.segments import Segments
from morph.model.shooting import predict

Models = Mapping[str, tuple[Hypothesis, Array]]
"""Each model's hypothesis and point, by name."""


def rollouts(
    models: Models, segments: Segments, starts: Mapping[str, Array] = MappingProxyType({})
) -> dict[str, Array]:
    """Return what each model predicts, (segments, readings, channels), started as measured.

    Args:
        models: Each model.
        segments: The rollouts.
        starts: Other starts of some models, by name, shape (segments, nq + nv).
    """
    return {
        name: predict(hypothesis, segments, [point], [starts.get(name, segments.start)])[0]
        for name, (hypothesis, point) in models.items()
    }


def rmse(segments: Segments, predicted: Array) -> Array:
    """Return the root mean square error of each channel, shape (channels,)."""
    squared = np.where(segments.valid, (segments.reading - predicted) ** 2, 0.0)
    return np.asarray(np.sqrt(squared.sum(axis=(0, 1)) / segments.counts.sum(axis=0)))


def by_segment(segments: Segments, predicted: Array, unit: Array) -> Array:
    """Return each segment's squared error in units of `unit` squared, shape (segments,)."""
    squared = ((segments.reading - predicted) / unit) ** 2
    return np.asarray(np.where(segments.valid, squared, 0.0).sum(axis=(1, 2)))


def improvement_low90(before: Array, after: Array, seed: int) -> float:
    """Return the lower end of a 90 % interval of the share of squared error taken away.

    Source: Efron and Tibshirani 1993, chapter 13 (percentile bootstrap over segments).
    """
    rng = np.random.default_rng(seed)
    draws = rng.integers(len(before), size=(2000, len(before)))
    share = 1.0 - after[draws].sum(axis=1) / (before[draws].sum(axis=1) + 1e-30)
    return float(np.quantile(share, 0.05))


def traces(segments: Segments, predicted: Mapping[str, Array]) -> tuple[Trace, ...]:
    """Return every channel of every episode with NaN between one rollout and the next.

    Args:
        segments: Held-out rollouts.
        predicted: What each model predicts, (segments, readings, channels).
    """
    measurement, result = segments.measurement, []
    for number, episode in enumerate(segments.episodes):
        rows = np.flatnonzero(segments.episode == number)
        if not len(rows):
            continue
        for column in segments.read.tolist():

            def joined(values: Array, rows: Integers = rows, column: int = column) -> Array:
                parts = []
                for row in rows:
                    inside = segments.valid[row, :, column]
                    line = values[row, :, column] if values.ndim == 3 else values[row]
                    parts += [line[inside], [np.nan]]
                return np.concatenate(parts)

            offset = segments.before + segments.part + segments.first[:, None]
            result.append(
                Trace(
                    episode=episode.name,
                    channel=measurement.channels[column],
                    unit=measurement.units[column],
                    time=joined(offset * segments.step),
                    measured=joined(segments.reading),
                    models={name: joined(values) for name, values in predicted.items()},
                )
            )
    return tuple(result)
