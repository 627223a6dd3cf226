"""Manifold alignment by itself: what ten landmarks are worth, and when two bodies share nothing.

On bodies of the shelf the source's policy is seen through each map on the target, which was never
run under it; beside each map stands the same with its landmarks shuffled. The sweep changes one
thing at a time between two cart-poles in a formula, and asks which measure of the unlabelled data
foretells where alignment is no better than its shuffled control. Seeds 0 to 9 judge.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.stats import spearmanr

from align.arrays import Array
from experiments.aligning.cases import Case, cases_of, measured
from experiments.aligning.ways import FAMILY
from experiments.interval import DRAWS, LEVEL, iqm
from experiments.kept import finished, seeds_of
from morph.arrays import JSON
from morph.files import write_whole

EXAMPLE = """example:
  python -m experiments.manifolds --seeds 10 --kept out/manifolds.jsonl --plot out/manifolds.html
  python -m experiments.manifolds --quick"""

GOAL = ("manifold", "uma", "sparse")
"""Wang and Mahadevan, unsupervised alignment with landmarks, sparse coding."""

CLEAR = 0.1
"""A map is clearly above its shuffled control if the lower 95 % bound of the difference is more."""

BLIND = ("pairs", "error")
"""What is about labels, which no measure of unlabelled data can see."""


def figures(cases: Sequence[Case], rows: Sequence[JSON]) -> list[JSON]:
    """Return one line for each two bodies, or each level of what changes."""
    groups: dict[tuple[str, str, float], list[JSON]] = {}
    for case, row in zip(cases, rows, strict=True):
        groups.setdefault((case.source, case.target, case.level), []).append(row)
    found = []
    for (source, target, level), mine in groups.items():
        line: JSON = {"source": source, "target": target, "level": level, "seeds": len(mine)}
        line["ways"] = {name: _way(name, mine) for name in mine[0]["ways"]}
        line["measures"] = {
            name: float(np.median([row["measures"][name] for row in mine]))
            for name in mine[0]["measures"]
        }
        found.append(line)
    return found


def _way(name: str, rows: Sequence[JSON]) -> JSON:
    ways = [row["ways"] for row in rows]
    score = np.array([each[name]["score"] for each in ways])
    line: JSON = {
        "score": [iqm(score), *sure(score, middle=True)],
        "solved": float(np.mean(score >= 0.8)),
        "refused": sum("refused" in each[name] for each in ways),
    }
    if "agreement" in ways[0][name]:
        line["agreement"] = iqm(np.array([each[name]["agreement"] for each in ways]))
    control = f"{name}, shuffled"
    if control in ways[0]:
        gain = score - np.array([each[control]["score"] for each in ways])
        line["gain"] = [float(gain.mean()), *sure(gain)]
    if control in ways[0] and name != "pairs_only":
        more = score - np.array([each["pairs_only"]["score"] for each in ways])
        line["more"] = [float(more.mean()), *sure(more)]
    return line


def sure(x: Array, *, middle: bool = False) -> tuple[float, float]:
    """Return the 95 % bootstrap interval of a mean, or of an interquartile one, over seeds.

    As `experiments.interval.interval` does for one stratum, with all draws at once: both figures
    are weighted sums of sorted numbers, and there are some thousand intervals here.
    """
    n = len(x)
    # The weights of the last 1, 2, ... sorted numbers together; their differences are the weights.
    steps = [iqm((np.arange(n) >= k).astype(float)) for k in range(n)]
    weight = -np.diff([*steps, 0.0]) if middle else np.full(n, 1.0 / n)
    draws = np.random.default_rng(0).integers(n, size=(DRAWS, n))
    found = np.sort(x[draws], axis=1) @ weight
    tail = 0.5 * (1.0 - LEVEL)
    low, high = np.quantile(found, (tail, 1.0 - tail), method="nearest")
    return float(low), float(high)


def clear(lines: Sequence[JSON]) -> dict[str, list[str]]:
    """Return on which bodies of the shelf each method is clearly above its shuffled control."""
    return {
        name: [
            f"{line['source']} > {line['target']} ({line['level']:g})"
            for line in lines
            if line["source"] != "formula" and line["ways"][name]["gain"][1] > CLEAR
        ]
        for name in (each.name for each in FAMILY)
    }


def foretold(lines: Sequence[JSON]) -> list[JSON]:
    """Return how each measure ranks the levels of the sweep against the gain of each method."""
    seen = [ln for ln in lines if ln["source"] == "formula" and ln["target"] not in BLIND]
    if len(seen) < 4:
        return []
    found = []
    for measure in seen[0]["measures"]:
        x = np.array([line["measures"][measure] for line in seen])
        row: JSON = {"measure": measure}
        for name in GOAL:
            y = np.array([line["ways"][name]["gain"][0] for line in seen])
            tied = np.ptp(x) == 0.0 or np.ptp(y) == 0.0
            row[name] = 0.0 if tied else float(spearmanr(x, y).statistic)
        found.append(row)
    return found


def shown(lines: Sequence[JSON], console: Console) -> None:
    """Print the tables."""
    for line in lines:
        if line["source"] != "formula":
            console.print(_bodies(line))
    sweep = Table(
        title="sweep: score [95 %] of a method, its gain over shuffled landmarks; agreement"
    )
    for name in ("what", "level", *GOAL, "pairs only", "no landmark", "features", "measures"):
        sweep.add_column(name)
    for line in lines:
        if line["source"] == "formula":
            ways = line["ways"]
            sweep.add_row(
                line["target"],
                f"{line['level']:g}",
                *(_short(ways[name]) for name in (*GOAL, "pairs_only")),
                *(f"{ways[name]['score'][0]:.2f}" for name in ("manifold_free", "features")),
                " ".join(f"{name} {value:.2f}" for name, value in line["measures"].items()),
            )
    console.print(sweep)
    for name, where in clear(lines).items():
        console.print(f"{name}: clearly above its shuffled control on {len(where)}: {where}")
    for row in foretold(lines):
        told = ", ".join(f"{name} {row[name]:+.2f}" for name in GOAL)
        console.print(f"Spearman of {row['measure']} with the gain: {told}")


def _short(way: JSON) -> str:
    sure = way["gain"][1] > CLEAR
    gain = f"{way['gain'][0]:+.2f}{'*' if sure else ''}"
    return f"{way['score'][0]:.2f} {gain} R2 {way['agreement']:.2f}"


def _bodies(line: JSON) -> Table:
    title = f"{line['source']} > {line['target']}, {line['level']:g} landmarks"
    table = Table(title=f"{title}, {line['seeds']} seeds")
    for name in ("way", "score [95 %]", "solved", "refused", "agreement", "over shuffled",
                 "over landmarks alone"):  # fmt: skip
        table.add_column(name)
    for name, way in line["ways"].items():
        gain, more = (
            f"{way[each][0]:+.2f} [{way[each][1]:.2f}, {way[each][2]:.2f}]" if each in way else ""
            for each in ("gain", "more")
        )
        score = way["score"]
        agreed = f"{way['agreement']:.2f}" if "agreement" in way else ""
        table.add_row(name, f"{score[0]:.2f} [{score[1]:.2f}, {score[2]:.2f}]",
                      f"{way['solved']:.2f}", str(way["refused"]), agreed, gain, more)  # fmt: skip
    return table


def drawn(lines: Sequence[JSON]) -> str:
    """Return the sweep as a page: score against what changes, one panel each."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    sweep = [line for line in lines if line["source"] == "formula"]
    factors = list(dict.fromkeys(line["target"] for line in sweep))
    figure = make_subplots(rows=1, cols=max(len(factors), 1), subplot_titles=factors)
    names = (*GOAL, "pairs_only", "manifold, shuffled", "manifold_free", "features")
    colours = ("#0072b2", "#009e73", "#d55e00", "#999999", "#000000", "#cc79a7", "#e69f00")
    for at, factor in enumerate(factors, start=1):
        mine = sorted((ln for ln in sweep if ln["target"] == factor), key=lambda ln: ln["level"])
        for name, colour in zip(names, colours, strict=True):
            score = np.array([line["ways"][name]["score"] for line in mine])
            figure.add_trace(
                go.Scatter(
                    x=[str(line["level"]) for line in mine],
                    y=score[:, 0],
                    error_y={"array": score[:, 2] - score[:, 0],
                             "arrayminus": score[:, 0] - score[:, 1]},
                    name=name, legendgroup=name, showlegend=at == 1, line={"color": colour},
                ), row=1, col=at,
            )  # fmt: skip
    figure.update_yaxes(range=[0, 1.05], title_text="score", col=1)
    figure.update_layout(title="Where two bodies share a manifold, and where not", height=480)
    return str(figure.to_html(include_plotlyjs=True, full_html=True))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.manifolds",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="10", help="from:to, or so many from 0 on")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--only", choices=("shelf", "sweep"), help="one of both parts")
    parser.add_argument("--kept", type=Path, help="a file of finished cases, to go on from")
    parser.add_argument("--json", type=Path, help="write figures and cases into this file")
    parser.add_argument("--plot", type=Path, help="draw the sweep as a page")
    parser.add_argument("--quick", action="store_true", help="two cases, seed 100")
    told = parser.parse_args(arguments)
    seeds = [100] if told.quick else seeds_of(told.seeds)
    cases = cases_of(seeds, quick=told.quick, only=told.only)
    workers = 1 if told.quick else told.workers
    try:
        rows = finished(cases, measured, kept=told.kept, workers=workers)
    except KeyboardInterrupt:
        return 130
    lines = figures(cases, rows)
    shown(lines, Console(width=170))
    if told.json:
        whole = [asdict(case) | row for case, row in zip(cases, rows, strict=True)]
        every = {"figures": lines, "clear": clear(lines), "foretold": foretold(lines)}
        write_whole(told.json, json.dumps(every | {"cases": whole}, indent=1) + "\n")
    if told.plot:
        write_whole(told.plot, drawn(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
