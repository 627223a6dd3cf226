"""Where the marks of the small drawings stand, in percent of their width.

They are drawn as plain HTML, so that they are read without scripts, by screen
readers and on paper.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from morph.app.report.words import limited, number, percent
from morph.model.diagnosis import Diagnosis, Stretch
from morph.model.finding import Estimate, Finding

MOST_STRIPS = 12
"""Held-out episodes drawn as strips."""


@dataclass(frozen=True, kw_only=True)
class Interval:
    """One estimate on a line, with a mark at the value that means no change."""

    name: str
    """What was estimated."""
    text: str
    """The estimate in figures."""
    low: float
    """Where its interval begins, percent."""
    width: float
    """How wide its interval is, percent."""
    best: float
    """Where its best value stands, percent."""
    mark: float | None
    """Where no change stands, percent; None if there is no such value."""


@dataclass(frozen=True, kw_only=True)
class BadStretch:
    """A bad stretch on the strip of its episode."""

    left: float
    """Where it begins, percent."""
    width: float
    """How wide it is, percent."""
    strength: float
    """How strongly it is coloured, 0 to 1."""
    text: str
    """It in words."""


@dataclass(frozen=True, kw_only=True)
class Strip:
    """One held-out episode on the common line of time."""

    episode: str
    """Its name."""
    width: float
    """Its length, percent of the longest."""
    seconds: float
    """Its length, s."""
    blocks: tuple[BadStretch, ...]
    """Its bad stretches, in the order of time."""


def parameter_intervals(finding: Finding) -> tuple[Interval, ...]:
    """Return a finding's parameters, each on a line of its own."""
    neutral = {p.name: p.neutral for p in finding.effect.parameters()}
    return tuple(
        _interval(name, estimate, neutral.get(name), _range([estimate], neutral.get(name)))
        for name, estimate in finding.parameters.items()
    )


def refit_intervals(diagnosis: Diagnosis) -> tuple[Interval, ...]:
    """Return the factors on the description's figures, on one common line around 1."""
    estimates = list(diagnosis.refit.values())
    reach = max((abs(v - 1.0) for e in estimates for v in _ends(e)), default=0.0)
    reach = max(1.15 * reach, 0.02)
    return tuple(
        _interval(name, estimate, 1.0, (1.0 - reach, 1.0 + reach))
        for name, estimate in diagnosis.refit.items()
    )


def strips(diagnosis: Diagnosis) -> tuple[Strip, ...]:
    """Return the held-out episodes that hold the worst stretches, or could."""
    by_episode: dict[str, list[Stretch]] = {}
    for stretch in diagnosis.located.times:
        by_episode.setdefault(stretch.episode, []).append(stretch)
    # Those with bad stretches come before those without, each in the order given.
    names = sorted(
        dict.fromkeys((*diagnosis.held_out, *by_episode)), key=lambda name: name not in by_episode
    )[:MOST_STRIPS]
    lengths = {name: _length(diagnosis, name, by_episode.get(name, [])) for name in names}
    longest = max(lengths.values(), default=0.0)
    worst = max((s.share for s in diagnosis.located.times), default=0.0)
    return tuple(
        Strip(
            episode=name,
            width=100.0 * seconds / longest,
            seconds=seconds,
            blocks=_blocks(by_episode.get(name, []), seconds, worst),
        )
        for name, seconds in lengths.items()
        if seconds > 0.0
    )


def _length(diagnosis: Diagnosis, episode: str, stretches: Iterable[Stretch]) -> float:
    times = [t.time[np.isfinite(t.time)] for t in diagnosis.traces if t.episode == episode]
    ends = [float(time.max()) for time in times if time.size] + [s.end for s in stretches]
    return max((end for end in ends if math.isfinite(end)), default=0.0)


def _blocks(stretches: Iterable[Stretch], seconds: float, worst: float) -> tuple[BadStretch, ...]:
    return tuple(
        BadStretch(
            left=100.0 * s.start / seconds,
            width=100.0 * (s.end - s.start) / seconds,
            strength=s.share / worst if worst > 0.0 else 0.0,
            text=f"{s.episode}, {number(s.start)} to {number(s.end)} s: {percent(s.share)}",
        )
        for s in sorted(stretches, key=lambda s: s.start)
        if seconds > 0.0
    )


def _ends(estimate: Estimate) -> tuple[float, ...]:
    values = (estimate.low90, estimate.value, estimate.high90)
    return tuple(value for value in values if math.isfinite(value))


def _range(estimates: Iterable[Estimate], mark: float | None) -> tuple[float, float]:
    """Return the ends of a line that shows every interval and the mark, with room."""
    values = [v for e in estimates for v in _ends(e)] + ([] if mark is None else [mark])
    low, high = min(values, default=0.0), max(values, default=1.0)
    room = 0.06 * (high - low) or 0.06 * abs(high) or 1.0
    return low - room, high + room


def _interval(
    name: str, estimate: Estimate, mark: float | None, ends: tuple[float, float]
) -> Interval:
    def at(value: float, otherwise: float) -> float:
        share = (value - ends[0]) / (ends[1] - ends[0])
        return min(max(100.0 * share, 0.0), 100.0) if math.isfinite(share) else otherwise

    low, high = at(estimate.low90, 0.0), at(estimate.high90, 100.0)
    unit = "" if estimate.unit in {"", "-"} else f" {estimate.unit}"
    return Interval(
        name=name,
        text=f"{number(estimate.value)}{unit}  "
        f"({number(estimate.low90)} to {number(estimate.high90)}){limited(estimate)}",
        low=low,
        width=max(high - low, 0.0),
        best=at(estimate.value, 50.0),
        mark=None if mark is None else at(mark, 0.0),
    )
