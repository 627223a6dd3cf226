"""Where, when and in which states a description and recordings part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from morph.arrays import Array, Mask
from morph.model.diagnosis import Located, Stretch
from morph.model.episodes import Episode
from morph.model.hypothesis import Hypothesis
from morph.model.motion import all_needed
from morph.model.segments import Segments

WORST = 5
"""Stretches that are named."""
FEWEST = 0.08
"""Least share of the samples for a state to be named: fewer may be chance."""
MARKED = 1.5
"""How much above average the missing force must be for a state to be named."""


def locate(
    hypothesis: Hypothesis,
    point: Array,
    episodes: Sequence[Episode],
    segments: Segments,
    predicted: Array,
) -> Located:
    """Return where the error of a model lies on held-out episodes.

    Args:
        hypothesis: The description, refitted, nothing added.
        point: Where it was fitted.
        episodes: Held-out episodes.
        segments: Their rollouts.
        predicted: What the model predicts there, (segments, readings, channels).
    """
    error = np.where(segments.valid, segments.reading - predicted, 0.0)
    squared = (error / segments.noise) ** 2
    total = float(squared.sum()) + 1e-30
    names, read = segments.measurement.channels, set(segments.read.tolist())
    of_channel = squared.sum(axis=(0, 1)) / total
    of_segment = squared.sum(axis=(1, 2)) / total
    times = []
    for index in np.argsort(-of_segment)[:WORST]:
        whole, (start, end) = segments.episodes[segments.episode[index]], segments.seconds(index)
        times.append(
            Stretch(
                episode=whole.name,
                recording=whole.recording.name,
                begin=whole.begin,
                start=start,
                end=end,
                share=float(of_segment[index]),
            )
        )
    return Located(
        channels={names[i]: float(of_channel[i]) for i in np.argsort(-of_channel) if i in read},
        times=tuple(times),
        states=_states(hypothesis, point, episodes),
    )


def _states(hypothesis: Hypothesis, point: Array, episodes: Sequence[Episode]) -> str:
    parts = all_needed(hypothesis, point, episodes, suspects=False)
    missing = np.concatenate([part.missing for part in parts])
    position = np.concatenate([part.motion.position for part in parts])
    velocity = np.concatenate([part.motion.velocity for part in parts])
    in_units = (missing / (np.sqrt(np.mean(missing**2, axis=0)) + 1e-18)) ** 2
    best, words = MARKED, "spread over all states that were visited"
    places = parts[0].motion.joints
    for joint in (each for each in hypothesis.robot.joints if each.kind in {"hinge", "slide"}):
        index = places[joint.name]
        speed, unit = velocity[:, index], joint.unit
        for text, inside in _conditions(joint.name, unit, position[:, index], speed):
            if inside.mean() < FEWEST:
                continue
            marked = float(in_units[inside, index].mean() / (in_units[:, index].mean() + 1e-30))
            if marked > best:
                best, words = marked, f"largest where {text}"
    return words


def _conditions(name: str, unit: str, position: Array, speed: Array) -> list[tuple[str, Mask]]:
    slow, fast = (float(q) for q in np.quantile(np.abs(speed), [0.25, 0.75]))
    low, high = (float(q) for q in np.quantile(position, [0.2, 0.8]))
    return [
        (f"abs({name}.velocity) < {slow:.2g} {unit}/s", np.abs(speed) < slow),
        (f"abs({name}.velocity) > {fast:.2g} {unit}/s", np.abs(speed) > fast),
        (f"{name}.position < {low:.2g} {unit}", position < low),
        (f"{name}.position > {high:.2g} {unit}", position > high),
    ]
