"""Figures of the gate: false answers at any moment, power, and how true its probabilities are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import JSON, Array, Mask

BINS = 10
"""Bins of a reliability table."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """What the gate said of one case, and what is true."""

    seed: int
    """Of the case."""
    family: str
    """The kind of target."""
    label: str
    """What differs."""
    moments: tuple[int, ...]
    """Numbers of transitions after which it was asked; the last is the whole run."""
    answers: tuple[str, ...]
    """What it answered at each."""
    sure: tuple[float, ...]
    """The probability of `good` at each."""
    truth: tuple[bool, ...]
    """Whether the model is good on these transitions."""
    inside: Mask
    """Whether it truly errs by less than epsilon at each transition, shape (periods,)."""
    transitions: Array
    """The probabilities of that at the end, shape (periods,)."""


def as_row(judged: Judged) -> JSON:
    """Return what the gate said of one case as plain data."""
    arrays = {"inside": judged.inside.tolist(), "transitions": judged.transitions.tolist()}
    return {**vars(judged), **arrays}


def of_row(row: JSON) -> Judged:
    """Return what `as_row` was given."""
    arrays = {
        "inside": np.array(row["inside"], dtype=bool),
        "transitions": np.array(row["transitions"]),
    }
    lists = {name: tuple(row[name]) for name in ("moments", "answers", "sure", "truth")}
    return Judged(**{**row, **lists, **arrays})


def is_good(error: Array, epsilon: Array, share: float) -> bool:
    """Return whether errors (transitions, n) are within epsilon at all but a share of them."""
    beyond = int((np.abs(error) >= epsilon).any(axis=1).sum())
    return beyond <= math.floor(share * len(error) + 1e-9)


def calibration(probability: Array, truth: Array, bins: int = BINS) -> float:
    """Return the expected calibration error: |probability - frequency|, averaged over cases.

    Source: Naeini, Cooper and Hauskrecht 2015, AAAI, eq. 3.
    """
    where = np.minimum((probability * bins).astype(int), bins - 1)
    return float(
        sum(
            abs(probability[where == at].mean() - truth[where == at].mean()) * np.mean(where == at)
            for at in np.unique(where)
        )
    )


def reliability(probability: Array, truth: Array, bins: int = BINS) -> list[JSON]:
    """Return each bin of probabilities with what came true, and an interval of that.

    Source: of the interval, Wilson 1927, J. American Statistical Association 22(158).
    """
    where = np.minimum((probability * bins).astype(int), bins - 1)
    rows = []
    for at in np.unique(where):
        count, right = int(np.sum(where == at)), float(truth[where == at].sum())
        low, high = wilson(right, count)
        rows.append(
            {
                "said": float(probability[where == at].mean()),
                "true": right / count,
                "low": low,
                "high": high,
                "cases": count,
            }
        )
    return rows


def wilson(right: float, count: int, z: float = 1.96) -> tuple[float, float]:
    """Return a 95 % interval of a share."""
    if not count:
        return 0.0, 1.0
    share = right / count
    middle = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z * math.sqrt(share * (1 - share) / count + z * z / (4 * count**2)) / (1 + z * z / count)
    return max(0.0, middle - half), min(1.0, middle + half)


def summary(cases: Sequence[Judged], delta: float) -> JSON:
    """Return what all cases amount to."""
    bad = [case for case in cases if not case.truth[-1]]
    good = [case for case in cases if case.truth[-1]]
    ever_bad = [case for case in cases if not all(case.truth)]
    ever_good = [case for case in cases if any(case.truth)]
    ending = np.array([case.sure[-1] for case in cases])
    true = np.array([case.truth[-1] for case in cases], dtype=float)
    each = np.concatenate([case.transitions for case in cases])
    inside = np.concatenate([case.inside for case in cases]).astype(float)
    return {
        "cases": len(cases),
        "good": len(good),
        "false_accepts": _ever(ever_bad, "good", False),
        "false_rejects": _ever(ever_good, "not good", True),
        "by_probability": {
            "false_accepts": _ever_sure(ever_bad, 1.0 - delta),
            "accepted": _share([case.sure[-1] >= 1.0 - delta for case in good]),
        },
        "always_accept": _share([True for _ in bad]) | {"wrong": len(bad) / max(len(cases), 1)},
        "accepted": _share([case.answers[-1] == "good" for case in good]),
        "good_withheld": _share([case.answers[-1] != "good" for case in good]),
        "rejected": _share([case.answers[-1] == "not good" for case in bad]),
        "bad_not_rejected": _share([case.answers[-1] != "not good" for case in bad]),
        "families": families(cases),
        "calibration": calibration(ending, true),
        "calibration_of_transitions": calibration(each, inside),
        "reliability": reliability(ending, true),
        "reliability_of_transitions": reliability(each, inside),
        "accuracy": float(np.mean((ending >= 0.5) == (true > 0.5))),
    }


def _share(right: Sequence[bool]) -> JSON:
    low, high = wilson(float(sum(right)), len(right))
    return {"count": sum(right), "of": len(right), "low": low, "high": high}


def _ever(cases: Sequence[Judged], answer: str, truth: bool) -> JSON:
    """Return in how many cases an answer was given at a moment when that was the truth."""
    return _share(
        [
            any(a == answer and t == truth for a, t in zip(case.answers, case.truth, strict=True))
            for case in cases
        ]
    )


def _ever_sure(cases: Sequence[Judged], least: float) -> JSON:
    return _share(
        [
            any(p >= least and not t for p, t in zip(case.sure, case.truth, strict=True))
            for case in cases
        ]
    )


def families(cases: Sequence[Judged]) -> list[JSON]:
    """Return the answers after the whole run, by kind of target and truth."""
    rows = []
    for family in dict.fromkeys(named(case) for case in cases):
        for truth in (True, False):
            mine = [c for c in cases if named(c) == family and c.truth[-1] == truth]
            if mine:
                said = [case.answers[-1] for case in mine]
                count = {
                    answer: said.count(answer) for answer in ("good", "not good", "cannot say")
                }
                right = count["good" if truth else "not good"]
                low, high = wilson(right, len(mine))
                rows.append(
                    {"family": family, "truly_good": truth, "cases": len(mine), "right": right}
                    | {"low": low, "high": high}
                    | count
                )
    return sorted(rows, key=lambda row: (row["family"], row["truly_good"]))


def named(case: Judged) -> str:
    """Return the family of a case, with the figure where that is the question."""
    return f"{case.family} {case.label}" if case.family in {"ten", "friction"} else case.family
