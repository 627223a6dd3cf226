"""The figures of the chain of balance: what each hop keeps, and what its samples stand against."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from experiments.interval import interval, iqm
from morph.arrays import JSON

GRID = (5, 10, 20, 40, 80)
"""Transitions from which learning without a source is tried."""

ALONE = ("ridge", "structured", "structured_cautious")
"""What fits the last body without any source."""

ENOUGH = 0.95
"""Share of the oracle's score that counts as balanced."""


def summary(found: Sequence[JSON]) -> JSON:
    """Return the figures, with intervals over seeds."""
    names = found[0]["names"]
    said: JSON = {"seeds": len(found), "hops": {}, "ends": {}}
    for name in names[1:]:
        kept = [each["hops"][name]["zero_shot"] / each["oracle"][name] for each in found]
        said["hops"][name] = {
            "kept": figure(kept),
            "solved": float(np.mean(np.array(kept) >= ENOUGH)),
            "hold_still": iqm(np.array([each["hold_still"][name] for each in found])),
            "oracle": iqm(np.array([each["oracle"][name] for each in found])),
        }
    for name in found[0]["ends"]:
        ends = [each["ends"][name] for each in found]
        optimum = [each["oracle"][name] for each in found]
        controls = {
            control: figure(
                [end["controls"][control] / best for end, best in zip(ends, optimum, strict=True)]
            )
            for control in ends[0]["controls"]
        }
        times = {
            way: [
                first(end["sourceless"][way], best) for end, best in zip(ends, optimum, strict=True)
            ]
            for way in ALONE
        }
        quickest = min(times, key=lambda way: float(np.mean(np.minimum(times[way], 2 * GRID[-1]))))
        took = np.minimum(times[quickest], 2 * GRID[-1])
        said["ends"][name] = {
            "samples": ends[0]["samples"],
            "controls": controls,
            "best_sourceless": quickest,
            "direct_samples": figure(list(took)),
            "direct_solved": float(np.isfinite(times[quickest]).mean()),
            "samples_over_direct": ends[0]["samples"] / iqm(took),
            "scratch": from_nothing(ends),
        }
    return said


def from_nothing(ends: Sequence[JSON]) -> JSON:
    """Return what learning from nothing took with its best size; nothing if it was not tried.

    Where it never arrived, `spent` is all that it had, less than it would take.
    """
    if not ends[0]["scratch"]:
        return {}
    by_size = {
        size: [end["scratch"][size] for end in ends] for size in ends[0]["scratch"]
    }  # fmt: skip

    def rank(size: str) -> tuple[float, float]:
        runs = by_size[size]
        return -sum(run["solved"] for run in runs), sum(run["spent"] for run in runs)

    best = min(by_size, key=rank)
    spent = [run["spent"] for run in by_size[best]]
    return {
        "size": best,
        "spent": figure(spent),
        "solved": float(np.mean([run["solved"] for run in by_size[best]])),
        "samples_over_scratch": ends[0]["samples"] / iqm(np.array(spent)),
    }


def first(curve: dict[str, float], optimum: float) -> float:
    """Return from how many transitions on a score stays enough; infinity if it never does."""
    took = np.inf
    for count in sorted(curve, key=int, reverse=True):
        if curve[count] < ENOUGH * optimum:
            break
        took = float(count)
    return took


def figure(values: Sequence[float]) -> JSON:
    """Return the interquartile mean with its interval."""
    low, high = interval(np.array(values))
    return {"iqm": iqm(np.array(values)), "low": low, "high": high}
