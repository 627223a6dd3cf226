"""Chains of gaits: what a swimming stroke keeps from three links to six paddles, or a real snake.

The score of a body is its speed over the best that long searches find on it, computed first and
kept by the body's hash. Each seed runs each chain once, with the same trials for every control,
and learns the last body directly from nothing by CMA-ES, servo by servo in water and by the names
of the servos on a floor, with three step sizes, of which the best over all seeds is taken. A
sample is a control period of 20 ms on a target.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.gaits_chained.cases import CHAINS, FULL, QUICK, REAL, Job, job
from experiments.gaits_chained.summary import summary
from experiments.needs import need_robots
from morph.arrays import JSON
from morph.errors import MorphError
from morph.files import write_whole
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.chains_gait --seeds 100:102 --quick
  python -m experiments.chains_gait --seeds 10 --resume --json out/gaits.json"""


def headline(found: Sequence[Mapping[str, Any]]) -> JSON:
    """Return what a result file holds: each chain's figures, and its controls after trials."""
    figures: JSON = {}
    controls: JSON = {}
    for chain in found:
        name = chain["chain"]
        figures |= flat({key: value for key, value in chain.items() if key != "after"}, name)
        for trials, each in chain["after"].items():
            figures[f"{name}_after_{trials}"] = each["chain"]["iqm"]
            controls[f"{name} after {trials} trials"] = {
                label: of["iqm"] for label, of in each.items() if label != "chain"
            }
    return {"figures": figures, "controls": controls, "rows": found}


def shown(figures: Mapping[str, Any], console: Console) -> None:
    """Print the figures of a chain as a table."""
    table = Table(title=f"chain {figures['chain']}: {figures['seeds']} seeds")
    table.add_column("figure")
    table.add_column("value")
    for name, value in figures.items():
        if name == "after":
            for trials, each in value.items():
                for label, figure in each.items():
                    table.add_row(f"after {trials} trials, {label}", _said(figure))
        elif name != "chain":
            table.add_row(name, _said(value))
    console.print(table)


def _said(value: Any) -> str:
    if isinstance(value, dict) and "iqm" in value:
        return f"{value['iqm']:.3g} [{value['low']:.3g}, {value['high']:.3g}]"
    if isinstance(value, dict):
        return ", ".join(f"{name} {each:.3g}" for name, each in value.items())
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.chains_gait",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", type=seeds_of, default=range(10), metavar="A:B")
    parser.add_argument("--chains", nargs="+", default=list(CHAINS), choices=list(CHAINS))
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures")
    parser.add_argument("--quick", action="store_true", help="one seed, few trials")
    add_engine_options(parser, out="out/chains_gait")
    given, save = parse_and_save(parser, arguments, module="experiments.chains_gait")
    size, seeds = (QUICK, given.seeds[:1]) if given.quick else (FULL, given.seeds)
    chains, real = given.chains, ""
    if "urma" in chains:
        try:
            real = str(need_robots(REAL.parts[0]))
        except MorphError as error:
            print(f"error: {error}\n  or leave it out: --chains aqua aracna", file=sys.stderr)
            return 2
    names = dict.fromkeys(name for chain in chains for name in CHAINS[chain])
    jobs = [Job(kind="best", name=name, seed=0, real=real, size=size) for name in names]
    jobs += [
        Job(kind="case", name=chain, seed=seed, real=real, size=size)
        for seed in seeds
        for chain in chains
    ]
    found = rows_of(cells_of(job, jobs), given, name="chains_gait")
    figures = [summary(found, chain) for chain in chains]
    console = Console()
    for each in figures:
        shown(each, console)
    if save:
        save(**headline(figures), seeds=seeds)
    if given.json is not None:
        write_whole(given.json, json.dumps(figures, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
