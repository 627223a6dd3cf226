"""The fluid in figures: how exact its tensors are, what it keeps, and what it costs.

Every speed is a ratio of times that were measured by turns in this run, the median of its
repeats; seconds are of the processor, on one core.
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
from threadpoolctl import threadpool_limits

from experiments.figures.save_options import parse_and_save
from experiments.wet.drift import KINDS, drift
from experiments.wet.growth import drawn, straightness
from experiments.wet.speed import cores, cost, growth
from experiments.wet.tensors import SHAPES, accuracy
from morph.arrays import JSON
from morph.errors import MorphError
from morph.files import write_whole

EXAMPLE = """example:
  python -m experiments.bench_fluid --plot out/fluid.html
  python -m experiments.bench_fluid --quick --json"""

BODIES = ("hexapod_swimmer", "humanoid")
"""Bodies of the shelf."""
TREES = (1, 2, 5, 10, 20, 30)
"""Links of the random trees."""
LINKS = (1, 2, 4, 8, 12, 16, 24, 32, 45, 60)
"""Links of the limbed bodies whose cost is drawn."""


def measured(*, quick: bool, seeds: Sequence[int]) -> JSON:
    """Return every figure; `quick` repeats less and only shows that all of it runs."""
    repeats, steps = (3, 100) if quick else (9, 2000)
    shapes = SHAPES[:1] if quick else SHAPES
    trees = (2, 5) if quick else TREES
    links = LINKS[:3] if quick else LINKS
    with threadpool_limits(1):
        tensors = [asdict(accuracy(radii)) for radii in shapes]
        drifts = {
            kind: {n: [drift(n, seed, kind) for seed in seeds] for n in trees} for kind in KINDS
        }
        costs = [asdict(cost(name, repeats=repeats, steps=steps)) for name in BODIES]
        dry, wet = growth(links, repeats=repeats, steps=max(steps // 10, 20))
        both = cores(BODIES[0], rows=64, repeats=repeats, steps=max(steps // 10, 20))
    return {
        "schema": "morph.bench_fluid/1",
        "quick": quick,
        "seeds": list(seeds),
        "tensors": tensors,
        "energy_drift": drifts,
        "costs": costs,
        "two_cores_by_one": both,
        "links": {"bodies": list(links), "dry_s": dry.tolist(), "wet_s": wet.tolist()},
        "links_straightness": straightness(links, wet),
    }


def report(found: JSON) -> None:
    """Print the figures as tables."""
    console = Console()
    table = Table(title="Lamb's ellipsoids, relative error along and about the worst axis")
    ways = {"": "1280 panels", "_extrapolated": "320, 1280", "_twice": "80, 320, 1280"}
    for title in ("semi-axes, m", *ways.values(), "s"):
        table.add_column(title, justify="right")
    for row in found["tensors"]:
        errors = [f"{row['linear' + way]:.3%}, {row['rotational' + way]:.3%}" for way in ways]
        table.add_row(" ".join(map(str, row["radii"])), *errors, f"{row['seconds']:.2f}")
    console.print(table)
    for kind, of in found["energy_drift"].items():
        every = np.array(list(of.values())).ravel()
        print(
            f"energy drift {kind}, trees of {min(of)} to {max(of)} links, RK4, 5 s at 5 ms: median "
            f"{np.median(every):.1e}, worst {every.max():.1e}, below 1e-6 in "
            f"{(every < 1e-6).sum()} of {len(every)}"
        )
    for row in found["costs"]:
        print(
            f"{row['name']} ({row['freedoms']} degrees of freedom): {row['over_dry']:.2f} times "
            f"the time of dry MuJoCo; MuJoCo's ellipsoid fluid takes {row['of_ellipsoid']:.1f} "
            f"times as long; {row['real_time']:.0f} times real time on a core at 5 ms"
        )
    print(f"two cores step {found['two_cores_by_one']:.2f} times as much as one")
    print(
        f"time by bodies, 1 to {found['links']['bodies'][-1]}: straight to "
        f"{found['links_straightness']:.1%} of its range"
    )


def headline(found: JSON) -> JSON:
    """Return what a result file holds: errors in percent, and prices as ratios of times."""
    worst = {
        way: max(max(row[f"linear{way}"], row[f"rotational{way}"]) for row in found["tensors"])
        for way in ("", "_extrapolated", "_twice")
    }
    drifts = {
        kind: np.array(list(of.values())).ravel() for kind, of in found["energy_drift"].items()
    }
    figures = {f"tensor_error{way}_percent": 100.0 * error for way, error in worst.items()}
    for row in found["costs"]:
        figures |= {
            f"{row['name']}_{key}": row[key]
            for key in ("freedoms", "over_dry", "of_ellipsoid", "real_time")
        }
    figures["two_cores_by_one"] = found["two_cores_by_one"]
    figures["links_straightness_percent"] = 100.0 * found["links_straightness"]
    return {
        "figures": figures,
        "controls": {
            kind: {"median_drift": np.median(every), "worst_drift": every.max()}
            for kind, every in drifts.items()
        },
        "rows": [*found["tensors"], *found["costs"]],
        "seeds": found["seeds"],
    }


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bench_fluid",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="few repeats: does it work at all")
    parser.add_argument("--seed", type=int, default=0, help="first of five seeds of the trees")
    parser.add_argument("--plot", metavar="FILE.html", help="draw the cost by number of bodies")
    parser.add_argument("--json", action="store_true", help="print JSON instead of words")
    asked, save = parse_and_save(parser, arguments, module="experiments.bench_fluid")
    try:
        seeds = range(asked.seed, asked.seed + (2 if asked.quick else 5))
        found = measured(quick=asked.quick, seeds=seeds)
        if save:
            save(**headline(found))
        if asked.plot:
            write_whole(Path(asked.plot), drawn(found["links"]))
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
