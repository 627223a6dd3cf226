"""Searches in figures: how often, how soon and at what loss each finds a policy that works.

A policy counts as strict if at least 95 of 100 noisy runs reach every goal: for a swing-up the
cart within 0.15 m and every link within 0.17 rad through the last half second. The seeds 0 to 19
judge; the searches were built on others. Seconds are wall time of one process on two cores.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from experiments.search import growth, model_free, moments
from experiments.search.controls import controls, do_nothing, throughput
from experiments.search.swing import Run, runs
from morph.arrays import JSON
from morph.body.load import load
from morph.errors import MorphError
from morph.files import write_whole
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.sim.integrator import Integrator

EXAMPLE = """example:
  python -m experiments.bench_search --only inside --seeds 5
  python -m experiments.bench_search --plot out/search.html --json > out/search.json
  python -m experiments.bench_search --quick"""

INSIDE = (("ddp", "swing-up", "cartpole"),)
"""Search, task and robot inside the simulator."""

LINKS = tuple(
    (search, name, body)
    for body in ("double_pendulum", "cart_two_links")
    for search, name in (("ddp", "swing-up"), ("lqr", "balance"))
)
"""The same with two links."""

FROM_DATA = "gp-ddp"
"""The search that learns from trials alone."""

TRIALS = 4
"""Policy trials that it may make."""


STEPPERS: tuple[Integrator, ...] = ("implicitfast", "rk4")
"""What closed loops are stepped by."""

PERIODS = (25, 50, 100, 200, 400, 800)
"""Control periods of the plans whose price is drawn."""


def _told(each: Run) -> None:
    trials = f", trials {' '.join(f'{loss:.1f}' for loss in each.trial_losses)}"
    print(
        f"  seed {each.seed}: {each.seconds:.1f} s, loss {each.loss:.2f}, "
        f"{each.share:.0%} strict{trials if each.trial_losses else ''}",
        file=sys.stderr,
        flush=True,
    )


def _beside_nothing(
    search: str, name: str, body: str, seeds: range, *, trials: int | None = None
) -> JSON:
    """Return the runs of a search, and what doing nothing gives on the same task."""
    nothing = do_nothing(name, body, seed=seeds[0])
    found = runs(search, name, body, seeds, trials=trials, told=_told)
    return found | {"doing_nothing": {"loss": nothing.loss, "strict_share": nothing.share}}


def _inside(seeds: range, quick: bool) -> list[JSON]:
    return [_beside_nothing(*each, seeds) for each in INSIDE]


def _links(seeds: range, quick: bool) -> list[JSON]:
    return [_beside_nothing(*each, seeds) for each in LINKS[: 1 if quick else None]]


def _data(seeds: range, quick: bool) -> list[JSON]:
    trials = 1 if quick else TRIALS
    return [_beside_nothing(FROM_DATA, "swing-up", "cartpole", seeds, trials=trials)]


def _throughput(seeds: range, quick: bool) -> JSON:
    robot = load("cartpole")
    policy = Linear(
        action=actions_of(robot),
        observation=observations_of(robot),
        period=0.05,
        weight=np.array([[1.0, 2.0, 1.0, 1.0]]),
        bias=np.zeros(1),
    )
    counts = (64,) if quick else (256, 1024, 4096)
    return {
        integrator: {
            str(rows): throughput("cartpole", policy, rows=rows, integrator=integrator)
            for rows in counts
        }
        for integrator in STEPPERS
    }


def _growth(seeds: range, quick: bool) -> JSON:
    repeats = 1 if quick else 5
    return {
        "bodies": growth.by_body(growth.BODIES[: 2 if quick else None], repeats=repeats),
        "horizons": growth.by_horizon(
            (25, 50) if quick else (25, 50, 100, 200, 400, 800), repeats=repeats
        ),
        "data": growth.by_data((30, 60) if quick else (60, 120, 240, 480), repeats=repeats),
    }


def _model_free(seeds: range, quick: bool) -> JSON | None:
    if not model_free.installed():
        return None
    return model_free.baseline(seeds[0], trials=8 if quick else 150)


PARTS: dict[str, Callable[[range, bool], object]] = {
    "inside": _inside,
    "links": _links,
    "data": _data,
    "moments": lambda seeds, quick: moments.measured(quick=quick),
    "controls": lambda seeds, quick: [
        vars(each) | {"loss": each.loss, "share": each.share}
        for each in controls("swing-up", "cartpole", seed=seeds[0])
    ],
    "throughput": _throughput,
    "growth": _growth,
    "model-free": _model_free,
}
"""Every part by its name."""


def report(found: JSON) -> None:
    """Print the figures as tables."""
    console = Console()
    table = Table(title="Searches: policies judged by 100 noisy runs a seed")
    for title in ("search", "task", "robot", "strict", "median loss", "median s", "worst s"):
        table.add_column(title, justify="left" if title in {"search", "task", "robot"} else "right")
    for part in ("inside", "links", "data"):
        for row in found.get(part, []):
            table.add_row(
                row["search"],
                row["task"],
                row["robot"],
                f"{row['strict']} of {row['seeds']}",
                f"{row['median_loss']:.2f}",
                f"{row['median_seconds']:.1f}",
                f"{row['worst_seconds']:.1f}",
            )
    console.print(table)
    for row in found.get("data", []):
        within = ", ".join(f"{most}: {count}" for most, count in row["strict_within"].items())
        print(
            f"{row['search']}, trials on the target alone: seeds with a strict trial within so "
            f"many policy trials: {within}; median loss of the last trial "
            f"{row['median_loss_of_last_trial']:.2f}"
        )
    for each in found.get("controls", []):
        print(f"{each['name']}: loss {each['loss']:.2f}, {each['share']:.0%} strict")
    for integrator, rates in found.get("throughput", {}).items():
        each = ", ".join(f"{rows}: {rate:,.0f}" for rows, rate in rates.items())
        print(f"closed loops with a linear policy by {integrator}, steps/s by cart-poles: {each}")
    if "moments" in found:
        moments.report(found["moments"])
    if found.get("growth"):
        of = found["growth"]
        for key, x, y in (
            ("bodies", "freedoms", "seconds"),
            ("horizons", "periods", "seconds"),
            ("data", "data", "fit_s"),
        ):
            points = [f"{row[x]}: {row[y]:.3g}" for row in of[key]]
            print(f"seconds by {x} ({key}): {', '.join(points)}")
    if "model-free" in found:
        print(f"SAC: {found['model-free'] or 'stable-baselines3 is not installed'}")


def headline(found: JSON) -> JSON:
    """Return what a result file holds of the parts that were run, each search by its names."""
    rows = [row for part in ("inside", "data", "links") for row in found.get(part, [])]
    baselines = found.get("controls", [])
    figures: JSON = {}
    controls: JSON = {}
    for row in rows:
        name = f"{row['robot']} {row['task']}"
        own = "" if len(rows) == 1 else f"{figure_name(name)}_"
        keys = ("seeds", "strict", "median_loss", "median_seconds", "worst_seconds")
        figures |= {own + key: row[key] for key in keys}
        for most, count in (row.get("strict_within") or {}).items():
            figures[f"{own}strict_within_{most}"] = count
        controls[f"doing nothing, {name}"] = row["doing_nothing"]
    for each in baselines:
        summary = {"loss": each["loss"], "strict": each["share"]}
        figures |= {f"{figure_name(each['name'])}_{key}": value for key, value in summary.items()}
        if each["name"] != "the learned policy":
            controls[each["name"]] = summary
    for stepper, rates in found.get("throughput", {}).items():
        figures |= {f"{stepper}_{many}_steps_per_s": rate for many, rate in rates.items()}
    for body in found.get("growth", {}).get("bodies", []):
        figures[f"{body['freedoms']}_freedoms_s"] = body["seconds"]
    moments_found = found.get("moments", {})
    figures |= {key: value for key, value in moments_found.items() if isinstance(value, float)}
    rows = [*rows, *baselines]
    return {"figures": figures, "controls": controls, "rows": rows, "seeds": found["seeds"]}


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bench_search",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", nargs="+", choices=tuple(PARTS), help="these parts alone")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", type=int, default=20, help="how many seeds")
    parser.add_argument("--quick", action="store_true", help="little of each: does it work at all")
    parser.add_argument("--plot", metavar="FILE.html", help="draw how the price grows")
    parser.add_argument("--json", action="store_true", help="print JSON instead of words")
    asked, save = parse_and_save(parser, arguments, module="experiments.bench_search")
    try:
        seeds = range(asked.seed, asked.seed + (1 if asked.quick else max(1, asked.seeds)))
        found: JSON = {"schema": "morph.bench_search/1", "seeds": list(seeds)}
        for part in asked.only or PARTS:
            print(f"{part} ...", file=sys.stderr, flush=True)
            found[part] = PARTS[part](seeds, asked.quick)
        if save:
            save(**headline(found))
        if asked.plot and "growth" in found:
            write_whole(Path(asked.plot), growth.drawn(found["growth"]))
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if asked.json:
        print(json.dumps(found, indent=1))
    else:
        report(found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
