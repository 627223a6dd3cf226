"""The figures of many scored answers, with bootstrap intervals over cases."""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from experiments.concealed.suites import WAYS

JSON = dict[str, Any]
Figure = Callable[[Sequence[JSON]], float | None]
RESAMPLES = 500
SHOWN = 2.0
"""Least effect-to-noise, after refits of own parameters, of all effects of a case that shows it."""
FRICTION = {
    "coulomb_friction",
    "stribeck_friction",
    "load_dependent_friction",
    "position_dependent_friction",
    "hysteresis",
}
"""Laws of dry friction: any of them at a joint says that there is some."""
LOAD, GAIN, WITHIN = "payload", "torque_scale", 0.1
"""Laws of a load and of a drive's gain, and up to which relative error a load is found."""


def _share(rows: Sequence[JSON], key: str, of: Callable[[JSON], bool]) -> float | None:
    chosen = [row for row in rows if of(row)]
    return float(np.mean([bool(row[key]) for row in chosen])) if chosen else None


def _effects(row: JSON) -> bool:
    return bool(row["answer"] == "effects")


def _several(count: int) -> Callable[[JSON], bool]:
    return lambda row: _effects(row) and len(row["truth"]) == count


def _shown(of: Callable[[JSON], bool]) -> Callable[[JSON], bool]:
    """Return a choice of those of some cases in which own parameters cannot hide an effect."""
    return lambda row: of(row) and min(row["after_refit"], default=0.0) >= SHOWN


def _outside(row: JSON) -> bool:
    return bool(row["answer"] == "unknown")


def _begins(row: JSON) -> bool:
    return bool(row["begun"])


def _ratio(rows: Sequence[JSON], part: str, whole: str) -> float | None:
    count = sum(row[whole] for row in rows)
    return sum(row[part] for row in rows) / count if count else None


def _middle(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _clean_accused(rows: Sequence[JSON]) -> float | None:
    clean = [row for row in rows if row["answer"] == "none"]
    return float(np.mean([bool(r["found"]) or r["unknown"] for r in clean])) if clean else None


def _extra(rows: Sequence[JSON]) -> float | None:
    chosen = [row["extra"] for row in rows if row["answer"] != "unknown"]
    return float(np.mean(chosen)) if chosen else None


def _places(labels: Sequence[str], laws: Collection[str]) -> set[str]:
    """Return where some laws act, of labels such as `coulomb_friction@elbow`."""
    parted = (label.split("@", 1) for label in labels)
    return {where for law, where in parted if law in laws}


def _friction_named(rows: Sequence[JSON]) -> float | None:
    """Return the share of joints with dry friction at which some law of it is found."""
    there = [_places(row["truth"], FRICTION) for row in rows]
    named = [_places(row["found"], FRICTION) for row in rows]
    count = sum(len(each) for each in there)
    return sum(len(a & b) for a, b in zip(there, named, strict=True)) / count if count else None


def _load_found(rows: Sequence[JSON]) -> float | None:
    loaded = [row["load"] for row in rows if _places(row["truth"], {LOAD})]
    return float(np.mean([e is not None and e <= WITHIN for e in loaded])) if loaded else None


def _gain_accused(rows: Sequence[JSON]) -> float | None:
    right = [row for row in rows if _effects(row)]
    wrong = [_places(r["found"], {GAIN}) - _places(r["truth"], {GAIN}) for r in right]
    return float(np.mean([bool(each) for each in wrong])) if right else None


def calibration_error(claims: Sequence[tuple[float, bool]], bins: int = 10) -> float | None:
    """Return the expected calibration error over equal bins of probability.

    Source: Naeini, Cooper and Hauskrecht 2015, AAAI, eq. 3.

    Args:
        claims: Stated probabilities, and whether what they are of was so.
        bins: Number of bins.
    """
    if not claims:
        return None
    stated, true = (np.array(each, dtype=float) for each in zip(*claims, strict=True))
    place = np.minimum((stated * bins).astype(int), bins - 1)
    gaps = [abs((stated - true)[place == b].sum()) for b in range(bins)]
    return float(sum(gaps) / len(stated))


def _ece(rows: Sequence[JSON]) -> float | None:
    return calibration_error([claim for row in rows for claim in row["claims"]])


def _ece_by_chance(rows: Sequence[JSON]) -> float | None:
    """Return the calibration error that the claims would have were each exactly as probable."""
    stated = np.array([claim for row in rows for claim in row["claims"]], dtype=float)
    if not len(stated):
        return None
    drawn = np.random.default_rng(0).random((200, len(stated))) < stated[:, 0]
    errors = [calibration_error(list(zip(stated[:, 0], each, strict=True))) for each in drawn]
    return float(np.mean([error for error in errors if error is not None]))


def _brier(rows: Sequence[JSON]) -> float | None:
    claims = [claim for row in rows for claim in row["claims"]]
    return float(np.mean([(p - t) ** 2 for p, t in claims])) if claims else None


def _coverage(rows: Sequence[JSON]) -> float | None:
    held = [each for row in rows for each in row["intervals"]]
    return float(np.mean(held)) if held else None


def _improvement(rows: Sequence[JSON]) -> list[float]:
    return [row["E"] for row in rows if row["E"] is not None and _effects(row)]


def _median(rows: Sequence[JSON]) -> float | None:
    values = _improvement(rows)
    return float(np.median(values)) if values else None


def _worst(rows: Sequence[JSON]) -> float | None:
    return min((row["E"] for row in rows if row["E"] is not None), default=None)


def _seconds(rows: Sequence[JSON], families: Collection[str]) -> float | None:
    """Return the median CPU time of an answer to a case of some mechanisms, s."""
    some = [row["seconds"] for row in rows if row["family"] in families]
    return float(np.median(some)) if some else None


def _logged(way: str, figure: Figure, rows: Sequence[JSON]) -> float | None:
    """Return a figure of cases that were logged in one of several ways."""
    if len({row["way"] for row in rows}) == 1:
        return None
    return figure([row for row in rows if row["way"] == way])


FIGURES: Mapping[str, Figure] = {
    "first": lambda rows: _share(rows, "first", _effects),
    "first_three": lambda rows: _share(rows, "first_three", _effects),
    "place": lambda rows: _share(rows, "place", _effects),
    "exact_set": lambda rows: _share(rows, "exact", _effects),
    "exact_set_of_one": lambda rows: _share(rows, "exact", _several(1)),
    "exact_set_of_two": lambda rows: _share(rows, "exact", _several(2)),
    "exact_set_of_three": lambda rows: _share(rows, "exact", _several(3)),
    "first_shown": lambda rows: _share(rows, "first", _shown(_effects)),
    "first_three_shown": lambda rows: _share(rows, "first_three", _shown(_effects)),
    "place_shown": lambda rows: _share(rows, "place", _shown(_effects)),
    "exact_set_shown": lambda rows: _share(rows, "exact", _shown(_effects)),
    "extra_per_case": _extra,
    "friction_named": _friction_named,
    "load_found": _load_found,
    "gain_accused": _gain_accused,
    "push_recall": lambda rows: _ratio(rows, "pushes_found", "pushes"),
    "push_precision": lambda rows: _ratio(rows, "pushes_found", "pushes_claimed"),
    "push_late_s": lambda rows: _middle(row["push_late"] for row in rows),
    "change_found": lambda rows: _share(rows, "change_found", _begins),
    "change_named": lambda rows: _share(rows, "change_named", _begins),
    "change_claimed_wrongly": lambda rows: _share(
        rows, "changes", lambda row: not row["begun"] and any(each["begun"] for each in rows)
    ),
    "clean_accused": _clean_accused,
    "unknown_right": lambda rows: _share(rows, "unknown", _outside),
    "unknown_right_shown": lambda rows: _share(rows, "unknown", _shown(_outside)),
    "unknown_wrong": lambda rows: _share(rows, "unknown", lambda r: r["answer"] != "unknown"),
    "ece": _ece,
    "ece_by_chance": _ece_by_chance,
    "brier": _brier,
    "coverage": _coverage,
    "E_median": _median,
    "E_worst": _worst,
    "seconds_median": lambda rows: _seconds(rows, {row["family"] for row in rows}),
    "seconds_two_joints": lambda rows: _seconds(rows, {"cart_pole", "double_pendulum"}),
    "seconds_six_joints": lambda rows: _seconds(rows, {"six_joint_arm"}),
    **{
        f"{name}_where_{way}": functools.partial(_logged, way, figure)
        for way in WAYS
        for name, figure in {
            "first": lambda rows: _share(rows, "first", _effects),
            "place": lambda rows: _share(rows, "place", _effects),
            "exact_set": lambda rows: _share(rows, "exact", _effects),
            "clean_accused": _clean_accused,
        }.items()
    },
}
"""Every figure of the table; None where no case or no answer bears on it."""


def summarise(rows: Sequence[JSON], *, seed: int = 0) -> JSON:
    """Return every figure with its 90 % bootstrap interval over cases, and the number of cases.

    Source: Efron and Tibshirani 1993, An Introduction to the Bootstrap, section 13.3.
    """
    rng = np.random.default_rng(seed)
    draws = [rng.integers(len(rows), size=len(rows)) for _ in range(RESAMPLES)] if rows else []
    out: JSON = {"cases": len(rows)}
    for name, figure in FIGURES.items():
        value = figure(rows)
        if value is None:
            out[name] = None
            continue
        resampled = [figure([rows[i] for i in draw]) for draw in draws]
        known = [x for x in resampled if x is not None]
        low, high = np.quantile(known, [0.05, 0.95])
        out[name] = {"value": value, "low90": float(low), "high90": float(high)}
    return out
