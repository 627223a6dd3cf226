"""Figure 1 of the thesis: a biped balances, the biped walks, the humanoid walks.

First the biped learns to stand: how stiff its joints are, how damped, and where they rest. Then
to walk half a metre in five seconds, begun from those numbers or from nothing. Then the humanoid
does: what its set points do to its feet is learned from 60 transitions of a tenth of a second, and
so is a map from the biped's joints to its own; the biped's gait, seen through the map and slowed
or quickened by the length of the legs, is where a search begins. Sideways the biped knows nothing:
how the humanoid sways is sought with the rest. All searches are CMA-ES with as many runs.

Beside it stand the map alone (the same search begun from no gait), a search of the humanoid's own
gaits from nothing (begun narrow, and wide), and the gait through the map with the signs of the
right leg flipped or all rows shuffled. A search has solved its task when its best of a generation
walks in 7 of 8 runs that chose nothing, twice. The seeds 0 to 9 judge.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.interval import interval, iqm
from experiments.walkers import WAYS, Case, measured
from morph.arrays import JSON
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.figure_one --seeds 0:10 --resume --json out/one.json
  python -m experiments.figure_one --quick"""


def summary(rows: Sequence[JSON]) -> JSON:
    """Return, for each way on each body, its share of runs, how often it solved, and after what."""
    found: JSON = {}
    for body in ("biped", "humanoid"):
        for way in dict.fromkeys(way for row in rows for way in row[body]):
            each = [row[body][way] for row in rows if way in row[body]]
            share = np.array([one["share"] for one in each])
            runs = np.array([one["runs"] for one in each])
            low, high = interval(share)
            found[f"{body}: {way}"] = {
                "share": iqm(share),
                "low": low,
                "high": high,
                "first": iqm(np.array([one["first"] for one in each])),
                "walked": iqm(np.array([one["walked"] for one in each])),
                "solved": float(np.isfinite(runs).mean()),
                "runs": iqm(runs),
                "seeds": len(each),
            }
    return found


def headline(found: JSON) -> JSON:
    """Return what a result file holds: carried gaits, and beside them every other start."""
    reached = {
        name: {key: value for key, value in of.items() if np.isfinite(value)}
        for name, of in found.items()
    }
    controls = {
        name.replace(":", ""): of
        for name, of in reached.items()
        if not name.endswith((": carried", ": stand"))
    }
    return {"figures": flat(reached), "controls": controls}


def report(found: JSON) -> None:
    """Print the figures as a table."""
    table = Table(title="Figure 1: share of runs that reach every goal, interquartile means")
    for title in ("body: way", "share", "95 %", "at first", "m", "solved", "runs until"):
        table.add_column(title)
    for name, each in found.items():
        table.add_row(
            name,
            f"{each['share']:.2f}",
            f"{each['low']:.2f} to {each['high']:.2f}",
            f"{each['first']:.2f}",
            "-" if name.endswith("stand") else f"{each['walked']:.2f}",
            f"{each['solved']:.0%} of {each['seeds']}",
            f"{each['runs']:.0f}",
        )
    Console().print(table)


def main(words: Sequence[str] | None = None) -> None:
    """Run the study by the words of a command line."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.figure_one",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="10", help="how many, or from:to (default 10)")
    ways = "these ways alone (default all but the last)"
    parser.add_argument("--only", nargs="+", choices=WAYS, help=ways)
    parser.add_argument("--json", type=Path, help="where the figures go")
    add_engine_options(parser, out="out/figure_one")
    parser.add_argument("--quick", action="store_true", help="one seed, one generation")
    told, save = parse_and_save(parser, words, module="experiments.figure_one")
    case = Case(seed=100, ways=tuple(told.only or WAYS[:-1]))
    if told.quick:
        cases = [replace(case, standing=1, walking=1, ways=("carried",))]
    else:
        cases = [replace(case, seed=seed) for seed in seeds_of(told.seeds)]
    rows = rows_of(cells_of(measured, cases), told, name="figure_one")
    found = summary(rows)
    if save:
        save(**headline(found), rows=rows, seeds=[each.seed for each in cases])
    if told.json:
        text = json.dumps({"ways": found, "cases": rows, "of": asdict(case)}, indent=1)
        told.json.write_text(text)
    report(found)


if __name__ == "__main__":
    main(sys.argv[1:])
