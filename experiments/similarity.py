"""Similarity of bodies against measured jumpstart: which source to carry from, before it runs.

Forty bodies about those of the shelf; each is a target of six others, three of its own family whose
policies are carried as they are, three planar ones whose policies are carried by the shelf's
description of the target's family, which the target itself no longer quite obeys. The jumpstart is
what the carried policy then scores beyond holding still. Beside what a policy promises on the
target's linear model (of its own description, or believed from 60 noisy transitions) stand the
share of steps that can be followed (thesis, eq. 11), the distance of transitions, agreement of
dynamics one step ahead, and what needs no model: figures, names and chance.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from rich.console import Console
from scipy.stats import spearmanr

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.kin.likeness import EACH, likeness
from experiments.kin.measures import ALIKE, Rows, chosen_well, lines_of, within
from morph.arrays import JSON, Array
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.similarity --seeds 0:10 --resume --json out/similar.json
  python -m experiments.similarity --quick"""

METRICS = (
    "promise by description",
    "promise of 60",
    "promise of the mean",
    "agreement",
    "eq. 11",
    "Wasserstein",
    "figures",
    "name",
    "random",
)
"""What is compared; of each the source with the most is chosen, the first of equal ones."""


def report(lines: list[JSON]) -> JSON:
    """Return the figures of the study from the lines of its pairs."""
    told = [line for line in lines if "why" not in line]
    jumpstart = np.array([line["jumpstart"] for line in told])
    targets = [line["target"] for line in told]
    names = {line["source"] for line in told} | set(targets)
    spread = np.quantile(jumpstart, (0.1, 0.25, 0.5, 0.75, 0.9))
    return {
        "pairs": len(told),
        "bodies": len(names),
        "targets": len(set(targets)),
        "refused": len(lines) - len(told),
        "jumpstart at 10, 25, 50, 75, 90 %": [float(each) for each in spread],
        "noise of the best source": ALIKE,
        "figures": {
            name: _figures(np.array([line[name] for line in told]), jumpstart, targets)
            for name in METRICS
        },
    }


def _figures(promise: Array, jumpstart: Array, targets: list[str]) -> JSON:
    def rank(rows: Rows) -> float:
        if np.ptp(promise[rows]) == 0.0:
            return 0.0
        return float(spearmanr(promise[rows], jumpstart[rows]).statistic)

    right = chosen_well(targets, promise, jumpstart)
    chance = np.random.default_rng(0)
    drawn = [float(chance.choice(right, len(right)).mean()) for _ in range(1000)]
    return {
        "Spearman": rank(np.arange(len(promise))),
        "Spearman within": within(targets, rank),
        "best first": float(right.mean()),
        "best first within": [float(each) for each in np.quantile(drawn, (0.025, 0.975))],
    }


def main(argv: list[str] | None = None) -> int:
    """Run the study, say what came of it, and write it."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.similarity",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="0:10", metavar="A:B", help="which, or how many")
    parser.add_argument("--json", type=Path, help="write the figures here")
    add_engine_options(parser, out="out/similarity")
    parser.add_argument("--quick", action="store_true", help="one target of one seed, for a test")
    asked, save = parse_and_save(parser, argv, module="experiments.similarity")
    seeds = range(199, 200) if asked.quick else seeds_of(asked.seeds)
    each = 1 if asked.quick else EACH
    cases = [{"seed": seed, "number": number} for seed in seeds for number in range(each)]
    lines = lines_of(rows_of(cells_of(likeness, cases), asked, name="similarity"))
    found = report(lines)
    if save:
        rivals = {name: found["figures"][name] for name in METRICS[3:]}
        figures = flat({**found, "figures": None}) | flat(found["figures"])
        save(figures=figures, controls=rivals, seeds=seeds)
    text = json.dumps(found, indent=1)
    if asked.json is not None:
        asked.json.parent.mkdir(parents=True, exist_ok=True)
        asked.json.write_text(text + "\n")
    Console().print_json(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
