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

from experiments.aligning.cases import Case, cases_of, measured
from experiments.aligning.report import against_ridge, drawn, pair_table
from experiments.aligning.ways import FAMILY, GOAL, RIDGE
from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from experiments.interval import iqm, mean_interval
from morph.arrays import JSON
from morph.files import write_whole
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.manifolds --seeds 10 --resume --plot out/manifolds.html
  python -m experiments.manifolds --quick"""

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
        "score": [iqm(score), *mean_interval(score, middle=True)],
        "solved": float(np.mean(score >= 0.8)),
        "refused": sum("refused" in each[name] for each in ways),
    }
    if "agreement" in ways[0][name]:
        line["agreement"] = iqm(np.array([each[name]["agreement"] for each in ways]))
    control = f"{name}, shuffled"
    if control in ways[0]:
        gain = score - np.array([each[control]["score"] for each in ways])
        line["gain"] = [float(gain.mean()), *mean_interval(gain)]
    if control in ways[0] and name != RIDGE:
        more = score - np.array([each[RIDGE]["score"] for each in ways])
        line["more"] = [float(more.mean()), *mean_interval(more)]
    return line


def clear(lines: Sequence[JSON], over: str = "gain", least: float = CLEAR) -> dict[str, list[str]]:
    """Return on which bodies of the shelf each method is clearly above a control.

    Args:
        lines: Figures of the study.
        over: `gain` over its shuffled control, or `more` than ridge on the same landmarks.
        least: What the lower end of the interval must exceed.
    """
    return {
        name: [
            f"{line['source']} > {line['target']} ({line['level']:g})"
            for line in lines
            if line["source"] != "formula" and line["ways"][name][over][1] > least
        ]
        for name in (each.name for each in FAMILY)
    }


def worse(lines: Sequence[JSON]) -> dict[str, list[str]]:
    """Return on which bodies of the shelf each method is surely below ridge."""
    return {
        each.name: [
            f"{line['source']} > {line['target']} ({line['level']:g})"
            for line in lines
            if line["source"] != "formula" and line["ways"][each.name]["more"][2] < 0.0
        ]
        for each in FAMILY
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
            console.print(pair_table(line))
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
                *(_short(ways[name]) for name in (*GOAL, RIDGE)),
                *(f"{ways[name]['score'][0]:.2f}" for name in ("manifold_free", "features")),
                " ".join(f"{name} {value:.2f}" for name, value in line["measures"].items()),
            )
    console.print(sweep)
    console.print(against_ridge(lines))
    above, below = clear(lines, "more", 0.0), worse(lines)
    for name, where in clear(lines).items():
        console.print(
            f"{name}: clearly above its shuffled control on {len(where)}, surely above ridge on "
            f"the same landmarks on {len(above[name])}, surely below it on {len(below[name])}: "
            f"{above[name]}"
        )
    for row in foretold(lines):
        told = ", ".join(f"{name} {row[name]:+.2f}" for name in GOAL)
        console.print(f"Spearman of {row['measure']} with the gain: {told}")


def _short(way: JSON) -> str:
    sure = way["gain"][1] > CLEAR
    gain = f"{way['gain'][0]:+.2f}{'*' if sure else ''}"
    return f"{way['score'][0]:.2f} {gain} R2 {way['agreement']:.2f}"


def headline(lines: Sequence[JSON]) -> JSON:
    """Return what a result file holds: on how many pairs each method is above its control."""
    shelf = [line for line in lines if line["source"] != "formula"]
    figures: JSON = {}
    for level in sorted({line["level"] for line in shelf}):
        mine = [line for line in shelf if line["level"] == level]
        figures[f"pairs_{level:g}"] = len(mine)
        above, below = clear(mine, "more", 0.0), worse(mine)
        for name, where in clear(mine).items():
            figures[f"{name}_{level:g}_clear"] = len(where)
            figures[f"{name}_{level:g}_above_ridge"] = len(above[name])
            figures[f"{name}_{level:g}_below_ridge"] = len(below[name])
    for row in foretold(lines):
        figures |= {f"{figure_name(row['measure'])}_{name}": row[name] for name in GOAL}
    rows = [
        {"source": line["source"], "target": line["target"], "level": line["level"]}
        | {
            name: [way["score"][0], *way.get("gain", ()), *way.get("more", ())]
            for name, way in line["ways"].items()
        }
        for line in lines
    ]
    shuffled = {
        f"{line['source']} > {line['target']}, {line['level']:g}": {
            name: way["score"][0] for name, way in line["ways"].items() if name not in GOAL
        }
        for line in shelf
    }
    return {"figures": figures, "controls": shuffled, "rows": rows}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.manifolds",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="10", help="from:to, or so many from 0 on")
    add_engine_options(parser, out="out/manifolds")
    parser.add_argument("--only", choices=("shelf", "sweep"), help="one of both parts")
    parser.add_argument("--json", type=Path, help="write figures and cases into this file")
    parser.add_argument("--plot", type=Path, help="draw the sweep as a page")
    parser.add_argument("--quick", action="store_true", help="two cases, seed 100")
    told, save = parse_and_save(parser, arguments, module="experiments.manifolds")
    seeds = [100] if told.quick else seeds_of(told.seeds)
    cases = cases_of(seeds, quick=told.quick, only=told.only)
    rows = rows_of(cells_of(measured, cases), told, name="manifolds")
    lines = figures(cases, rows)
    shown(lines, Console(width=170))
    if save:
        save(**headline(lines), seeds=seeds)
    if told.json:
        whole = [asdict(case) | row for case, row in zip(cases, rows, strict=True)]
        every = {
            "figures": lines,
            "clear": clear(lines),
            "above_ridge": clear(lines, "more", 0.0),
            "below_ridge": worse(lines),
            "foretold": foretold(lines),
        }
        write_whole(told.json, json.dumps(every | {"cases": whole}, indent=1) + "\n")
    if told.plot:
        write_whole(told.plot, drawn(lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
