"""Iterations of one body: a policy carried along ten changes, against learning each body anew.

Every iteration changes all lengths, masses and motors of the body before it by chance. Carried is
what is believed of the lengths, masses and motors: each body is asked for COUNT transitions of
20 ms, the belief is updated, and the regulator of the most probable body runs. Learning anew fits
a linear model to the same body's transitions with no source, by whole runs (`anew`) and from
reading to reading (`regressed`). The score is that of balancing under a push, 0 to 1.

Beside them stand holding still, the first body's law never adjusted, the carried law through a
map whose signs are flipped or whose parts are shuffled, a search by trials from nothing over three
step sizes on the last body, and the regulator of the true body (oracle). The seeds 0 to 9 judge.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.interval import interval, iqm
from experiments.iterated import BODIES, Case, measured
from morph.arrays import JSON
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.iterations --seeds 0:10 --resume --json out/it.json
  python -m experiments.iterations --quick"""


def summary(cases: Sequence[JSON]) -> JSON:
    """Return the interquartile means of all ways, with intervals, and how often each is enough."""
    bodies = tuple(dict.fromkeys(case["body"] for case in cases))
    found: JSON = {"scores": {}, "enough": {}, "last": {}}
    names = dict.fromkeys(n for case in cases for row in case["rows"] for n in row["scores"])
    for name in names:
        found["scores"][name] = _middle(cases, bodies, name, last=False)
        found["last"][name] = _middle(cases, bodies, name, last=True)
    for way in ("carried", "anew", "regressed", "scratch"):
        spent = [
            float(row["enough"][way])
            for case in cases
            for row in case["rows"]
            if way in row["enough"]
        ]
        if spent:
            solved = np.isfinite(spent)
            found["enough"][way] = {
                "solved": float(solved.mean()),
                "iqm": iqm(np.array(spent)),
                "iterations": len(spent),
            }
    return found


def _middle(cases: Sequence[JSON], bodies: Sequence[str], name: str, *, last: bool) -> JSON | None:
    """Return the figure of one way: strata are bodies, and a seed's iterations count by their mean.

    A way that stopped because it was enough keeps the score that it had reached.
    """
    table = []
    for body in bodies:
        rows = [
            case["rows"][-1:] if last else case["rows"] for case in cases if case["body"] == body
        ]
        held = [[r["scores"][name] for r in each if name in r["scores"]] for each in rows]
        means = [float(np.mean(each)) for each in held if each]
        if not means:
            return None
        table.append(means)
    least = min(len(each) for each in table)
    scores = np.array([each[:least] for each in table])
    low, high = interval(scores)
    return {"iqm": iqm(scores), "low": low, "high": high, "seeds": least}


def report(found: JSON) -> None:
    """Print the figures as a table."""
    console = Console()
    table = Table(title="A body made again: score of balancing, interquartile means")
    for title in ("way", "all iterations", "the last"):
        table.add_column(title, justify="left" if title == "way" else "right")
    for name, all_of in found["scores"].items():
        if all_of:
            table.add_row(name, *(_said(each) for each in (all_of, found["last"][name])))
    console.print(table)
    for way, each in found["enough"].items():
        console.print(
            f"{way}: enough in {each['solved']:.0%} of {each['iterations']} iterations, "
            f"interquartile mean of transitions {each['iqm']:.3g}"
        )


def _said(each: JSON | None) -> str:
    return f"{each['iqm']:.3f} ({each['low']:.3f} to {each['high']:.3f})" if each else "-"


def main(words: Sequence[str] | None = None) -> None:
    """Run the study by the words of a command line."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.iterations",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="10", help="how many, or from:to (default 10)")
    parser.add_argument("--only", nargs="+", choices=list(BODIES), help="these bodies alone")
    parser.add_argument("--json", type=Path, help="where the figures go")
    add_engine_options(parser, out="out/iterations")
    parser.add_argument("--quick", action="store_true", help="one body, one seed, two changes")
    told, save = parse_and_save(parser, words, module="experiments.iterations")
    if told.quick:
        cases = [Case(body="cartpole", seed=100, changes=2, anew=(6, 20), trials=0)]
    else:
        bodies = told.only or list(BODIES)
        cases = [Case(body=body, seed=seed) for seed in seeds_of(told.seeds) for body in bodies]
    rows = rows_of(cells_of(measured, cases), told, name="iterations")
    found = summary(rows)
    if save:
        seeds = sorted({case.seed for case in cases})
        controls = {name: each for name, each in found["scores"].items() if name != "carried"}
        save(figures=flat(found), controls=controls, rows=rows, seeds=seeds)
    if told.json:
        told.json.write_text(json.dumps(found | {"cases": rows}, indent=1))
    report(found)


if __name__ == "__main__":
    main(sys.argv[1:])
