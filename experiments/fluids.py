"""Six fluids and ballasts of the swimmer: does eq. 13 tell from 5 s in which of them it swims?

Truths are one of the six (`clean`), one of them with a current and with drags and thrust that are
off (`disturbed`), half way between two (`between`), and far from all (`none`). Beside the choice
stand those that take samples for independent, one that takes models for exact, an oracle that
knows the disturbance, and answers shuffled. The seeds 0 to 99 judge; 100 and above are to build
on. Stopped by Ctrl-C it tells what it has.
"""

from __future__ import annotations

import argparse
import json
import sys
import time

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from experiments.waters.cases import KINDS, drawn
from experiments.waters.judge import Judge, Verdict, scored, summed
from morph.arrays import JSON
from morph.errors import MorphError

EXAMPLE = """example:
  python -m experiments.fluids --quick
  python -m experiments.fluids --seeds 100 --json > out/fluids.json"""

COLUMNS = {
    "right": "right",
    "confidence": "sure",
    "calibration": "calibration error",
    "by_chance": "by chance",
    "log_loss": "log loss",
    "shuffled": "shuffled",
    "on_neighbours": "on neighbours",
    "none": "none fits",
    "flagged": "none > 1/2",
}
"""Figures and their titles."""


def judged(kinds: list[str], seeds: range) -> tuple[dict[str, list[Verdict]], bool]:
    """Return the verdicts of every kind of truth, and whether it was stopped before its end."""
    judge = Judge()
    found: dict[str, list[Verdict]] = {kind: [] for kind in kinds}
    began = time.monotonic()
    try:
        for seed in seeds:
            for kind in kinds:
                found[kind].append(judge.verdict(drawn(kind, seed)))
            print(f"seed {seed}, {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        return {kind: verdicts for kind, verdicts in found.items() if verdicts}, True
    return found, False


def figures(found: dict[str, list[Verdict]]) -> JSON:
    """Return everything that the study says."""
    rng = np.random.default_rng(0)
    told: JSON = {kind: summed(verdicts, rng) for kind, verdicts in found.items()}
    known = [each for kind in ("clean", "disturbed") for each in found.get(kind, [])]
    if known:
        truth = np.repeat([each.case.truth[0] for each in known], len(known[0].none))
        told["clean and disturbed, all times"] = [
            {
                "method": method,
                "seconds": None,
                "confidence": float(
                    np.concatenate([each.told[method] for each in known]).max(axis=1).mean()
                ),
                **scored(np.concatenate([each.told[method] for each in known]), truth, rng),
            }
            for method in known[0].told
        ]
    return told


def report(told: JSON) -> None:
    """Print the figures as tables."""
    wide = Console(width=140)
    for kind, rows in told.items():
        table = Table(title=kind, title_justify="left")
        table.add_column("method")
        table.add_column("s", justify="right")
        columns = [name for name in COLUMNS if any(name in row for row in rows)]
        for name in columns:
            table.add_column(COLUMNS[name], justify="right")
        for row in rows:
            seconds = "" if row["seconds"] is None else f"{row['seconds']:g}"
            values = [f"{row[name]:.3f}" if name in row else "" for name in columns]
            table.add_row(row["method"], seconds, *values)
        wide.print(table)


def headline(told: JSON) -> JSON:
    """Return what a result file holds: each method at the last moment, kind by kind."""
    last = max(row["seconds"] for row in told["clean"] if row["seconds"] is not None)
    figures: JSON = {"seconds": last}
    controls: JSON = {}
    for kind, rows in told.items():
        for row in rows:
            if row["seconds"] not in (None, last):
                continue
            numbers = {key: row[key] for key in COLUMNS if key in row and np.isfinite(row[key])}
            if row["method"] == rows[0]["method"]:
                figures |= {f"{figure_name(kind)}_{key}": value for key, value in numbers.items()}
            else:
                controls[f"{kind}: {row['method']}"] = numbers
    rows = [{"kind": kind, **row} for kind, rows in told.items() for row in rows]
    return {"figures": figures, "controls": controls, "rows": rows}


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.fluids",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", nargs="+", choices=KINDS, help="these kinds of truth alone")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", type=int, default=100, help="how many seeds (default 100)")
    parser.add_argument("--quick", action="store_true", help="one seed: does it work at all")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    asked, save = parse_and_save(parser, arguments, module="experiments.fluids")
    seeds = range(asked.seed, asked.seed + (1 if asked.quick else max(1, asked.seeds)))
    try:
        found, stopped = judged(asked.only or list(KINDS), seeds)
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if not found:
        return 130
    told = figures(found)
    if save and not stopped:
        save(**headline(told), seeds=seeds)
    if asked.json:
        rows = [each.row() for verdicts in found.values() for each in verdicts]
        print(json.dumps({"schema": "morph.fluids/1", "figures": told, "cases": rows}, indent=1))
    else:
        report(told)
    return 3 if stopped else 0


if __name__ == "__main__":
    sys.exit(main())
