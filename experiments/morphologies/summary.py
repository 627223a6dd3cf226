"""Figures of the study of one policy on many bodies: scores, and times until enough."""

from __future__ import annotations

import numpy as np

from experiments.figures.result_file import flat
from experiments.interval import interval, iqm
from experiments.morphologies.methods import KIN, MAPPED, SOURCELESS
from morph.arrays import JSON, Array

ENOUGH = 0.95
"""Share of the optimum that counts as balanced."""

FEW = 60
"""Transitions of the zero-shot row."""

HUMANOID = "humanoid_free"
"""The fifteenth body: a humanoid whose soles stand on a free skateboard; it has no kin here."""

WRONG = ("shuffled", "flipped")
"""Policies made anew over maps that are wrong."""


def gain_of(zero: JSON) -> int:
    """Return on how many more bodies the hop is enough than wrong maps and fits without a source.

    Of those that stand beside it the one that is enough on most counts.
    """
    rivals = [name for name in (*WRONG, *SOURCELESS) if name in zero]
    return int(zero["hop"]["solved"] - max(zero[name]["solved"] for name in rivals))


def in_words(said: JSON) -> str:
    """Return in one line what the hop solves, and what wrong maps and no source solve."""
    zero = said["zero_shot"]
    best = max(SOURCELESS, key=lambda name: zero[name]["solved"])
    shown = [("hop", "hop"), *((f"over a {name} map", name) for name in WRONG)]
    shown += [(f"without a source ({best})", best), ("from a body of the same joints", "kin")]
    told = ", ".join(
        f"{title} {zero[name]['solved']} of {len(zero[name]['bodies'])} ({zero[name]['iqm']:.2f})"
        for title, name in shown
        if name in zero
    )
    return (
        f"{FEW} transitions, {len(said['seeds'])} seeds, bodies with {ENOUGH:g} of the optimum "
        f"(interquartile mean): {told}; gain of the source {gain_of(zero):+d}"
    )


def first_enough(curve: dict[str, float], optimum: float) -> float:
    """Return from how many transitions on the score stays enough; infinity if it never does."""
    took = np.inf
    for count in sorted(curve, key=int, reverse=True):
        if curve[count] < ENOUGH * optimum:
            break
        took = float(count)
    return took


def summary(cases: list[JSON], generations: int) -> JSON:
    """Return the figures of both goals, with intervals over seeds within bodies."""
    bodies = sorted({each["body"] for each in cases})
    seeds = sorted({each["seed"] for each in cases})
    whole = {(each["body"], each["seed"]): each for each in cases}
    seeds = [seed for seed in seeds if all((body, seed) in whole for body in bodies)]
    names = [*MAPPED, *KIN, *SOURCELESS]

    def table(name: str, rows: list[str]) -> Array:
        return np.array(
            [
                [
                    whole[body, seed]["curves"][name][str(FEW)] / whole[body, seed]["oracle"]
                    for seed in seeds
                ]
                for body in rows
            ]
        )

    zero: JSON = {}
    for name in names:
        rows = [body for body in bodies if name in whole[body, seeds[0]]["curves"]]
        if not rows:
            continue
        scores = table(name, rows)
        zero[name] = {
            "iqm": iqm(scores),
            "interval": interval(scores),
            "bodies": {body: iqm(row) for body, row in zip(rows, scores, strict=True)},
            "solved": int(sum(iqm(row) >= ENOUGH for row in scores)),
        }
    counts = sorted(int(count) for count in cases[0]["curves"]["hop"])
    best = max(SOURCELESS, key=lambda name: _mean_of_curve(cases, name))
    with_kin = [body for body in bodies if body != HUMANOID]
    censored = 2 * counts[-1]
    return {
        "bodies": bodies,
        "seeds": seeds,
        "zero_shot": zero,
        "best_sourceless": best,
        "time_to_threshold": _times(whole, bodies, seeds, ("hop", best), censored, generations),
        "time_to_threshold_from_kin": _times(
            whole, with_kin, seeds, ("kin", best), censored, generations
        )
        if with_kin
        else None,
    }


def _mean_of_curve(cases: list[JSON], name: str) -> float:
    return float(np.mean([list(each["curves"][name].values()) for each in cases]))


def _times(
    whole: dict[tuple[str, int], JSON],
    bodies: list[str],
    seeds: list[int],
    ours_and_best: tuple[str, str],
    censored: int,
    generations: int,
) -> JSON:
    """Return times and how many times longer others take; a censored time is one grid step more.

    A ratio of two censored times is 1.
    """
    ours, best = ours_and_best
    said: JSON = {"censored_at": censored}
    times = {}
    for name in ours_and_best:
        rows = [
            [first_enough(whole[b, s]["curves"][name], whole[b, s]["oracle"]) for s in seeds]
            for b in bodies
        ]
        times[name] = np.array(rows)
        said[name] = {"solved": float(np.isfinite(times[name]).mean())}
        said[name]["bodies"] = {
            body: _said(iqm(np.minimum(row, censored)))
            for body, row in zip(bodies, times[name], strict=True)
        }
    soon = np.minimum(times[ours], censored)
    ratio = np.minimum(times[best], censored) / soon
    said["sourceless_over_ours"] = {"iqm": iqm(ratio), "interval": interval(ratio)}
    if generations:
        sizes = list(whole[bodies[0], seeds[0]]["scratch"])
        tuned, solved = [], []
        for body in bodies:
            by = np.array([[whole[body, s]["scratch"][size] for size in sizes] for s in seeds])
            # Of three sizes that which solves most, then soonest. What is unsolved counts by
            # what it used until then, which flatters it.
            at = int(np.lexsort((by[..., 0].mean(axis=0), -by[..., 1].mean(axis=0)))[0])
            tuned.append(by[:, at, 0])
            solved.append(by[:, at, 1])
        ratio = np.array(tuned) / soon
        said["scratch_over_ours"] = {"iqm": iqm(ratio), "interval": interval(ratio)}
        said["scratch_solved"] = float(np.mean(solved))
    return said


def _said(value: float) -> float | None:
    return value if np.isfinite(value) else None


def headline(found: JSON) -> JSON:
    """Return what a result file holds: shares of the optimum, bodies solved, and times."""
    figures: JSON = {
        "bodies": len(found["bodies"]),
        "best_sourceless": found["best_sourceless"],
        "gain": gain_of(found["zero_shot"]),
    }
    controls: JSON = {}
    for name, row in found["zero_shot"].items():
        told = {
            "share": row["iqm"],
            "low": row["interval"][0],
            "high": row["interval"][1],
            "solved": row["solved"],
            "of": len(row["bodies"]),
        }
        if name in ("hop", "kin", *WRONG, *SOURCELESS):
            figures |= flat(told, name)
        if name != "hop":
            controls[name] = told
    for name in ("time_to_threshold", "time_to_threshold_from_kin"):
        for ratio in ("sourceless_over_ours", "scratch_over_ours"):
            if found[name] and ratio in found[name]:
                of = found[name][ratio]
                low, high = of["interval"]
                figures |= flat({"": of["iqm"], "low": low, "high": high}, f"{name} {ratio}")
    rows = [{"body": body} | _by_body(found["zero_shot"], body) for body in found["bodies"]]
    return {"figures": figures, "controls": controls, "rows": rows}


def _by_body(zero: JSON, body: str) -> JSON:
    return {name: row["bodies"][body] for name, row in zero.items() if body in row["bodies"]}
