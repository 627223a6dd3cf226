"""Body and policy sought together, against one after the other and each alone.

The printed quadruped is to come as far ahead as it can in four seconds on a hard floor. Its card
lets the lower legs be 0.5 to 1.5 times as long, in front and at the rear; its gait has eleven
numbers. All ways have as many runs: together (13 numbers at once), by turns (gait, legs, gait,
legs), the gait alone on the body as described, the legs alone under the gait of the start, and
chance. What counts is how far the middle of the last generation comes in runs that chose nothing.
The seeds 0 to 9 judge.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.interval import interval, iqm
from morph.arrays import JSON, Array
from morph.body.load import load
from morph.search.codesign import POPULATION, Design, sought
from morph.search.family.family import Family
from morph.search.family.gait import gait
from morph.sim.threads import one_thread
from morph.study.cell import cells_of
from morph.task.task import Task
from morph.task.walk import walk

EXAMPLE = """example:
  python -m experiments.codesign --seeds 0:10 --resume --json out/codesign.json
  python -m experiments.codesign --quick"""

LEGS = tuple(
    tuple(f"{end}_{side}_lower_leg_size" for side in ("left", "right")) for end in ("front", "rear")
)
"""The lower legs, which are as long on the left as on the right."""

GENERATIONS = 16
"""Generations of every way, 12 runs each."""

HORIZON = 4.0
"""How long a run is, s."""

ROWS = 8
"""Runs by which what was found is judged."""

WAYS = ("together", "by turns", "gait alone", "legs alone", "chance")
"""Every way to spend the runs."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One way, one seed."""

    seed: int
    """Of all its chance."""
    way: str
    """One of WAYS."""
    generations: int = GENERATIONS
    """How many generations."""


def design() -> Design:
    """Return what is free of the printed quadruped."""
    return Design(
        robot=load("quadruped_printed"),
        groups=LEGS,
        pose=partial(walk, distance=0.5, horizon=HORIZON),
        family=_gait,
    )


def _gait(task: Task) -> Family:
    return gait(task.robot, period=task.period)


def measured(case: Case) -> JSON:
    """Return how far a way comes, and with which body."""
    with one_thread():
        plan = design()
        point, curve = _spent(plan, case)
        rng = np.random.default_rng((case.seed, 10**6))
        far = plan.far(point, rng=rng, rows=ROWS)
    legs = {group[0].partition("_")[0]: plan.values(point)[group[0]] for group in LEGS}
    return {"way": case.way, "seed": case.seed, "far": far, "curve": list(curve), "legs": legs}


def _spent(plan: Design, case: Case) -> tuple[Array, tuple[float, ...]]:
    gait_only, many = plan.of_policy, case.generations
    quarter = max(1, many // 4)
    phases = {
        "together": ((np.ones_like(gait_only), many),),
        "by turns": ((gait_only, quarter), (~gait_only, quarter)) * 2,
        "gait alone": ((gait_only, many),),
        "legs alone": ((~gait_only, many),),
    }
    if case.way == "chance":
        return _drawn(plan, case)
    found = sought(plan, phases[case.way], seed=case.seed)
    return found.point, found.curve


def _drawn(plan: Design, case: Case) -> tuple[Array, tuple[float, ...]]:
    """Return the best of as many points drawn anywhere."""
    rng = np.random.default_rng((case.seed, 0))
    points = rng.uniform(size=(case.generations * POPULATION, len(plan.start)))
    far = [plan.far(point, rng=rng) for point in points]
    return points[int(np.argmax(far))], tuple(np.maximum.accumulate(far)[POPULATION - 1 :: 12])


def summary(rows: Sequence[JSON]) -> JSON:
    """Return the interquartile mean of how far each way comes, with its interval."""
    found: JSON = {}
    for way in WAYS:
        far = np.array([row["far"] for row in rows if row["way"] == way])
        if not len(far):
            continue
        low, high = interval(far)
        legs = [list(row["legs"].values()) for row in rows if row["way"] == way]
        found[way] = {
            "iqm": iqm(far),
            "low": low,
            "high": high,
            "seeds": len(far),
            "legs": np.mean(legs, axis=0).tolist(),
        }
    return found


def report(found: JSON) -> None:
    """Print the figures as a table."""
    table = Table(title="Body and policy: metres ahead in 4 s, interquartile means")
    for title in ("way", "far", "95 %", "lower legs front, rear"):
        table.add_column(title)
    for way, each in found.items():
        legs = ", ".join(f"{value:.2f}" for value in each["legs"])
        table.add_row(way, f"{each['iqm']:.3f}", f"{each['low']:.3f} to {each['high']:.3f}", legs)
    Console().print(table)


def main(words: Sequence[str] | None = None) -> None:
    """Run the study by the words of a command line."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.codesign",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="10", help="how many, or from:to (default 10)")
    parser.add_argument("--only", nargs="+", choices=WAYS, help="these ways alone")
    parser.add_argument("--json", type=Path, help="where the figures go")
    add_engine_options(parser, out="out/codesign")
    parser.add_argument("--quick", action="store_true", help="one seed, one generation")
    told, save = parse_and_save(parser, words, module="experiments.codesign")
    ways = told.only or WAYS
    seeds = range(100, 101) if told.quick else seeds_of(told.seeds)
    many = 1 if told.quick else GENERATIONS
    cases = [Case(seed=seed, way=way, generations=many) for seed in seeds for way in ways]
    rows = rows_of(cells_of(measured, cases), told, name="codesign")
    found = summary(rows)
    if save:
        controls = {way: found[way] for way in ways[1:]}
        save(figures=flat(found), controls=controls, rows=[flat(row) for row in rows], seeds=seeds)
    if told.json:
        told.json.write_text(json.dumps({"ways": found, "cases": rows}, indent=1))
    report(found)


if __name__ == "__main__":
    main(sys.argv[1:])
