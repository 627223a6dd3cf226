"""Result of one hop of a chain: scores, controls and learning curves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from morph.arrays import JSON, Array
from morph.errors import TransferError
from morph.policy_transfer.parts import Arrow, Parts
from morph.policy_transfer.score import UNMEASURED
from morph.policy_transfer.transfer_record import GuardRecord

ENOUGH = 0.95
"""Share of what the oracle gains over holding still from which a policy counts as good."""

DRAWS = 1000
"""Bootstrap samples of an interval."""

LEVEL = 0.95
"""How often an interval should hold the truth."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """How good a way to a policy is, by how many transitions of the target it was given."""

    name: str
    """The way: `transfer`, `no_source`, or a control."""
    samples: tuple[int, ...]
    """How many transitions."""
    scores: Array
    """What came of them, drawn anew in each row, shape (repeats, points)."""

    def __post_init__(self) -> None:
        """Check the shape."""
        if self.scores.ndim != 2 or self.scores.shape[1:] != (len(self.samples),):
            raise TransferError(
                f"{len(self.samples)} counts have scores of the shape {self.scores.shape}",
                where=f"the learning curve of {self.name}",
                fix="give one row for each repeat and one column for each count",
            )

    @property
    def mean(self) -> Array:
        """The mean score at each count, shape (points,)."""
        return np.asarray(self.scores.mean(axis=0))

    @cached_property
    def interval(self) -> Array:
        """The ends of the mean's bootstrap interval at each count, shape (2, points).

        Source: Efron and Tibshirani 1993, An Introduction to the Bootstrap, section 13.3.
        """
        rng = np.random.default_rng(0)
        rows = rng.integers(len(self.scores), size=(DRAWS, len(self.scores)))
        tail = 0.5 * (1.0 - LEVEL)
        drawn = self.scores[rows].mean(axis=1)
        return np.asarray(np.quantile(drawn, (tail, 1.0 - tail), axis=0))

    def reached(self, level: float) -> int | None:
        """Return the least count from which on every mean is at least a level; None if none is."""
        below = np.flatnonzero(self.mean < level)
        first = int(below[-1]) + 1 if len(below) else 0
        return self.samples[first] if first < len(self.samples) else None


@dataclass(frozen=True, kw_only=True, eq=False)
class Crossing:
    """One hop: from a body to the next, over a learned map."""

    source: str
    """What the source is called."""
    target: str
    """What the target is called."""
    map: str
    """The map's file, beside the record."""
    kind: str
    """What sort of map it is."""
    parts: Parts
    """Which part is which."""
    quality: Mapping[str, float]
    """How good the map is."""
    guard: GuardRecord
    """What is thought of the policy before it is tried."""
    samples: int
    """Transitions of the target that it took."""
    measured: Mapping[str, float]
    """The task's score, 0 to 1, of the policies of `UNMEASURED` that were run, and of controls."""
    curves: tuple[Curve, ...] = ()
    """Learning curves, in the task's score."""
    notes: tuple[str, ...] = ()
    """What else is to be known."""

    def relative(self, value: float | Array) -> Array:
        """Return scores of the task as shares: 0 for holding still and 1 for the oracle.

        Where the oracle gains nothing over holding still there is no share to speak of.
        """
        still, oracle = self.measured["hold_still"], self.measured["oracle"]
        if oracle - still < 1e-3:
            return np.full(np.shape(value), np.nan)
        return np.asarray(np.clip((np.asarray(value) - still) / (oracle - still), 0.0, 1.0))

    @property
    def scores(self) -> dict[str, float | None]:
        """The scores that the record has, as shares; None for what was not measured."""
        results: dict[str, float | None] = {}
        for name in UNMEASURED:
            share = float(self.relative(self.measured.get(name, np.nan)))
            results[name] = share if np.isfinite(share) else None
        return results

    @property
    def good(self) -> bool:
        """Whether its policy is as good as the oracle, but for one part in twenty."""
        return (self.scores["final"] or 0.0) >= ENOUGH

    @property
    def threshold(self) -> float:
        """The task's score from which a policy counts as good."""
        still, oracle = self.measured["hold_still"], self.measured["oracle"]
        return still + ENOUGH * (oracle - still)

    @property
    def reached(self) -> dict[str, int | None]:
        """How many transitions each curve took to become good; None: more than were given."""
        return {curve.name: curve.reached(self.threshold) for curve in self.curves}

    def said(self) -> JSON:
        """Return it as a hop of the schema morph.transfer/1."""
        final = self.scores["final"]
        return {
            "source": self.source,
            "target": self.target,
            "map": self.map,
            "quality": dict(self.quality),
            "guard": vars(self.guard),
            "gate": None,
            "samples": self.samples,
            "score": self.scores,
            "success": dict.fromkeys(UNMEASURED),
            "succeeded": self.good,
            "why": "" if self.good else (
                "the oracle is no better than holding still" if final is None else
                f"its policy has {final:.2f} of what the oracle gains, less than {ENOUGH:g}"
            ),
            "trials": [],
            "differences": [],
            "rivals": [],
            "unsaid": None,
            "relay": {
                "kind": self.kind,
                "parts": parts_said(self.parts),
                "measured": dict(self.measured),
                "curves": [_curve(each) for each in self.curves],
                "reached": self.reached,
                "notes": list(self.notes),
            },
        }  # fmt: skip


def _curve(curve: Curve) -> JSON:
    low, high = curve.interval
    return {
        "name": curve.name,
        "samples": list(curve.samples),
        "repeats": len(curve.scores),
        "mean": curve.mean.tolist(),
        "low95": low.tolist(),
        "high95": high.tolist(),
    }


def parts_said(parts: Parts) -> JSON:
    """Return which part is which as plain data."""
    return {
        "states": [_arrow(each) for each in parts.states],
        "commands": [_arrow(each) for each in parts.commands],
        "lost": list(parts.lost),
    }


def _arrow(arrow: Arrow) -> JSON:
    return {"from": arrow.begin, "to": arrow.end, "weight": arrow.weight}
