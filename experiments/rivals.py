"""What a transfer is compared with, in figures: losses of five trials on changed cart-poles.

A swing-up is planned and seen on the cart-pole as it is; then every rival of
`morph/policy_transfer/baselines/` has five trials on one with a longer or shorter pole, more
friction or more mass, and, as a control, on the same cart-pole. Beside them: doing nothing, and a
plan on the target's true parameters. Losses are interquartile means over seeds with bootstrap
intervals (Agarwal and others 2021, Deep RL at the edge of the statistical precipice, NeurIPS).
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.stats import trim_mean

from experiments.engine_options import add_engine_options, rows_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from experiments.transfer.changed import changed, target_of
from morph.arrays import JSON, Array
from morph.policy_transfer.baselines.baselines import BASELINES
from morph.policy_transfer.baselines.source import Source
from morph.search.ddp import Plan
from morph.search.evaluate import evaluate
from morph.search.search import Problem
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.rivals --seeds 5 --resume --json > out/rivals.json
  python -m experiments.rivals --seed 100 --seeds 2 --worlds l*2 --rivals "pooled data"
  python -m experiments.rivals --quick"""

WORLDS: dict[str, tuple[str, float]] = {
    "l*1": ("l", 1.0),
    "l*2": ("l", 2.0),
    "l*0.5": ("l", 0.5),
    "b*11": ("b", 11.0),
    "m*4": ("m", 4.0),
}
"""Which of the thesis' parameters of figures 7 and 8 is multiplied, and by how much."""

TRIALS = 5
"""Trials on the target."""

OWN = "plan on the true parameters"
"""What the target's own optimum is called, as far as the search ddp finds it."""

STILL = "doing nothing"
"""The control that tells nothing to the motor."""

BOOTSTRAPS = 2000
"""Draws of an interval."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One rival on one target from one seed."""

    world: str
    """What was changed."""
    rival: str
    """Who tried."""
    seed: int
    """Of all chance."""
    losses: tuple[float, ...]
    """Of each trial."""
    successes: tuple[float, ...]
    """1 for each trial that reached every goal."""
    seconds: float
    """Wall time."""


def measured(world: str, rival: str, seed: int, trials: int) -> Row:
    """Return what one rival, or a control, does on one target."""
    task = changed(*WORLDS[world])
    target, began = target_of(task), time.perf_counter()
    if rival == OWN:
        simulator = task.simulator()
        own = Plan().run(Problem(task=task, simulator=simulator), seed=seed)
        score = evaluate(task, own.policy, simulator, rng=np.random.default_rng(seed))
        tried = [(score.mean, score.share)] * trials
    elif rival == STILL:
        still = np.zeros((task.samples - 1, len(task.robot.actuators)))
        shown = target.trial(still, np.random.default_rng(seed))
        tried = [(shown.loss, float(shown.success))] * trials
    else:
        (kind,) = (each for each in BASELINES if each.name == rival)
        source = source_of(seed)
        began = time.perf_counter()
        lines = kind().run(source, target, trials=trials, seed=seed)
        tried = [(line.loss, line.success) for line in lines]
    losses, successes = zip(*tried, strict=True)
    return Row(
        world=world,
        rival=rival,
        seed=seed,
        losses=losses,
        successes=successes,
        seconds=time.perf_counter() - began,
    )


@lru_cache(maxsize=1)
def source_of(seed: int) -> Source:
    """Return the swing-up of the unchanged cart-pole, planned in simulation, and what was seen."""
    task = changed("l", 1.0)
    found = Plan(margin=0.1).run(Problem(task=task, simulator=task.simulator()), seed=seed)
    return Source(task=task, policy=found.policy).with_experience(np.random.default_rng(seed))


def rows(found: Sequence[JSON]) -> list[Row]:
    """Return rows as they came of the engine."""
    return [
        Row(**{**row, "losses": tuple(row["losses"]), "successes": tuple(row["successes"])})
        for row in found
    ]


def middle(values: Array) -> float:
    """Return the interquartile mean."""
    return float(trim_mean(values, 0.25))


def interval(values: Array, rng: np.random.Generator) -> tuple[float, float]:
    """Return the bounds between which the interquartile mean is with 95 %, by bootstrap."""
    drawn = rng.choice(values, (BOOTSTRAPS, len(values)))
    low, high = np.percentile(trim_mean(drawn, 0.25, axis=1), (2.5, 97.5))
    return float(low), float(high)


def summary(found: Sequence[Row]) -> list[JSON]:
    """Return what each rival's losses amount to in each world, trial by trial."""
    rng = np.random.default_rng(0)
    told = []
    for world in dict.fromkeys(row.world for row in found):
        for rival in dict.fromkeys(row.rival for row in found if row.world == world):
            mine = [row for row in found if (row.world, row.rival) == (world, rival)]
            losses = np.array([row.losses for row in mine])
            told.append(
                {
                    "world": world,
                    "rival": rival,
                    "seeds": len(mine),
                    "loss": [middle(each) for each in losses.T],
                    "interval": [interval(each, rng) for each in losses.T],
                    "success": np.mean([row.successes for row in mine], axis=0).tolist(),
                    "seconds": float(np.median([row.seconds for row in mine])),
                }
            )
    return told


def harm(found: Sequence[Row], rival: str, control: str) -> list[JSON]:
    """Return by how much a rival costs more than a control, seed by seed, in each trial.

    The same seed has the same source, starts and noise in both.
    """
    rng = np.random.default_rng(0)
    told = []
    for world in dict.fromkeys(row.world for row in found):
        losses = [
            {row.seed: row.losses for row in found if (row.world, row.rival) == (world, name)}
            for name in (rival, control)
        ]
        both = sorted(set(losses[0]) & set(losses[1]))
        if both:
            more = np.array([np.subtract(losses[0][seed], losses[1][seed]) for seed in both])
            told.append(
                {
                    "world": world,
                    "rival": rival,
                    "control": control,
                    "more": [middle(each) for each in more.T],
                    "interval": [interval(each, rng) for each in more.T],
                }
            )
    return told


def report(found: JSON) -> None:
    """Print the figures as tables."""
    table = Table(title="Losses on changed cart-poles: interquartile mean [95 %], trial by trial")
    trials = len(found["summary"][0]["loss"])
    for title in ("world", "rival", *(f"trial {n + 1}" for n in range(trials)), "successes", "s"):
        table.add_column(title)
    for row in found["summary"]:
        table.add_row(
            row["world"],
            row["rival"],
            *_each(row["loss"], row["interval"]),
            " ".join(f"{share:.1f}" for share in row["success"]),
            f"{row['seconds']:.0f}",
        )
    console = Console(width=160)
    console.print(table)
    for row in found["harm"]:
        more = ", ".join(_each(row["more"], row["interval"]))
        console.print(f"{row['world']}: {row['rival']} costs more than {row['control']} by {more}")


def _each(values: Sequence[float], bounds: Sequence[tuple[float, float]]) -> list[str]:
    pairs = zip(values, bounds, strict=True)
    return [f"{value:.1f} \\[{low:.1f}, {high:.1f}]" for value, (low, high) in pairs]


def headline(found: JSON) -> JSON:
    """Return what a result file holds: each rival's loss and successes in its last trial."""
    figures: JSON = {}
    for row in found["summary"]:
        told = {"loss": row["loss"][-1], "success": row["success"][-1]}
        figures |= flat(told, f"{row['world']} {row['rival']}")
    for row in found["harm"]:
        figures |= flat({"pooling_harm": row["more"][-1]}, row["world"])
    controls = {
        f"{row['world']}: {row['rival']}": {"loss": row["loss"][-1]}
        for row in found["summary"]
        if row["rival"] in (OWN, STILL)
    }
    return {"figures": figures, "controls": controls, "rows": found["summary"]}


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    names = [*(each.name for each in BASELINES), STILL, OWN]
    parser = argparse.ArgumentParser(
        prog="python -m experiments.rivals",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--worlds", nargs="+", choices=tuple(WORLDS), default=list(WORLDS))
    parser.add_argument("--rivals", nargs="+", choices=names, default=names)
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", type=int, default=5, help="how many seeds")
    add_engine_options(parser, out="out/rivals")
    parser.add_argument("--quick", action="store_true", help="little: does it work at all")
    parser.add_argument("--json", action="store_true", help="print JSON instead of words")
    asked, save = parse_and_save(parser, arguments, module="experiments.rivals")
    if asked.quick:
        asked.seeds, asked.worlds = 1, ["l*2"]
        asked.rivals = ["unadjusted", "target data alone", "pooled data", STILL]
    seeds = range(asked.seed, asked.seed + max(1, asked.seeds))
    trials = 2 if asked.quick else TRIALS
    cases = [
        {"world": world, "rival": rival, "seed": seed, "trials": trials}
        for seed in seeds
        for world in asked.worlds
        for rival in asked.rivals
    ]
    all_rows = rows(rows_of(cells_of(measured, cases), asked, name="rivals"))
    found: JSON = {
        "schema": "morph.rivals/1",
        "seeds": list(seeds),
        "summary": summary(all_rows),
        "harm": harm(all_rows, "pooled data", "target data alone"),
        "rows": [asdict(row) for row in all_rows],
    }
    if save:
        save(**headline(found), seeds=seeds)
    if asked.json:
        print(json.dumps(found, indent=1))
    else:
        report(found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
