"""The figures of a chain of gaits over its seeds."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.gaits_chained.cases import CHAINS, ENOUGH
from experiments.interval import interval, iqm
from morph.arrays import Array, Mask

AFTER = (1, 4, 8, 16, 32)
"""Trials on the last body after which the chain is held against its controls."""


def summary(found: list[dict[str, Any]], chain: str) -> dict[str, Any]:
    """Return the figures of a chain over its seeds."""
    best = {each["case"][5:]: max(each["best"].values()) for each in found if "best" in each}
    cases = [each for each in found if each.get("chain") == chain and "hops" in each]
    failed = [each["seed"] for each in found if each.get("chain") == chain and "failed" in each]
    if not cases:
        return {"chain": chain, "seeds": 0, "failed": failed}
    names = CHAINS[chain]
    top = best[names[-1]]
    scores = np.array(
        [[hop["speed"] / best[n] for hop, n in zip(c["hops"], names, strict=True)] for c in cases]
    )
    final = scores[:, -1]
    samples = np.array([sum(hop["samples"] for hop in c["hops"][1:]) for c in cases])
    own = np.array([c["hops"][0]["samples"] for c in cases])
    levels = np.minimum(ENOUGH, final) * top
    rivals = {label: _times(cases, label, levels) for label in cases[0]["direct"]}
    tuned = min(rivals, key=lambda label: float(rivals[label][0].mean()))
    spent, reached = rivals[tuned]
    return {
        "chain": chain,
        "seeds": len(cases),
        "failed": failed,
        "best_m_s": {n: best[n] for n in names},
        "score_by_body": {n: iqm(scores[:, at]) for at, n in enumerate(names)},
        "final": _figure(final),
        "lost_per_hop": _figure((scores[:, 0] - final) / (len(names) - 1)),
        "solved": float((final >= ENOUGH).mean()),
        "samples": _figure(samples),
        "samples_with_source": _figure(samples + own),
        "direct_tuned": tuned,
        "direct_samples_at_least": _figure(spent),
        "direct_censored": float((~reached).mean()),
        "direct_score": _figure(_best_of(cases, "direct", tuned) / top),
        "ratio_at_most": _figure(samples / spent),
        "after": {
            str(trials): {
                "chain": _figure(
                    np.array([max(c["hops"][-1]["speeds"][:trials]) for c in cases]) / top
                ),
                **{
                    label: _figure(_best_of(cases, "controls", label, trials) / top)
                    for label in cases[0]["controls"]
                },
            }
            for trials in AFTER
        },
    }


def _best_of(
    cases: list[dict[str, Any]], kind: str, label: str, trials: int | None = None
) -> Array:
    return np.array([max(each[kind][label][:trials]) for each in cases])


def _times(cases: list[dict[str, Any]], label: str, levels: Array) -> tuple[Array, Mask]:
    """Return the samples that direct learning took to each level, and whether it got there.

    Where it did not, they are all that it had: it would have taken more.
    """
    rows = np.array([each["direct"][label] for each in cases]) >= levels[:, None]
    trials = np.where(rows.any(axis=1), rows.argmax(axis=1) + 1, rows.shape[1])
    return trials * np.array([each["trial"] for each in cases]), np.asarray(rows.any(axis=1))


def _figure(x: Array) -> dict[str, Any]:
    low, high = interval(x)
    return {"iqm": iqm(x), "low": low, "high": high}
