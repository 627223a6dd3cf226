"""How well the cart-pole's balance policy serves many bodies, and how soon, from few transitions.

Told of a target: its transitions near rest, the noise and period, the bounds of its commands, and
which linear numbers of its state its task looks at. Judged runs begin with a push that no
transition shows. Beside the hop stand the map alone, wrong maps, what fits the target without
any source, learning from nothing, holding still, and the oracle on the true model.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from align.samples import Transitions
from experiments.interval import interval, iqm
from experiments.morphologies.methods import (
    KIN,
    MAPPED,
    SOURCELESS,
    from_kin,
    kin_of,
    mapped,
    sourceless,
)
from experiments.morphologies.scratch import SIZES, scratch
from morph.arrays import JSON, Array
from morph.transfer.balancers import PLANAR, balancer, seen_with
from morph.transfer.body import linear_law, still_law
from morph.transfer.mapped.belief import read
from morph.transfer.mapped.feedback import plain
from morph.transfer.relay import tried
from morph.transfer.riders import rider

EXAMPLE = """example:
  python -m experiments.zero_shot --seeds 0:10 --json out/zero_shot.json --kept out/zero_shot.jsonl
  python -m experiments.zero_shot --seeds 0:10 --noise 0.001 --json out/zero_shot_noisy.json
  python -m experiments.zero_shot --seeds 100:102 --bodies cart_two_links --no-scratch"""

ENOUGH = 0.95
"""Share of the optimum that counts as balanced."""

FEW = 60
"""Transitions of the zero-shot row."""

COUNTS = (2, 5, 10, 15, 20, 30, 60)
"""Transitions of the learning curves."""

ROWS = 2
"""Judged runs of every feedback."""


HUMANOID = "humanoid_free"
"""The fifteenth body: a humanoid whose soles stand on a free skateboard; it has no kin here."""

BODIES = (*PLANAR, HUMANOID)
"""Every target."""


def case(
    body: str, seed: int, *, counts: tuple[int, ...], generations: int, noise: float = 0.0
) -> JSON:
    """Return the scores of one body under one seed, by what ran and from how many transitions."""
    source = seen_with(balancer("cartpole"), noise)
    target = seen_with(rider(body) if body == HUMANOID else balancer(body), noise)
    kin = None if body == HUMANOID else kin_of(body, np.random.default_rng([seed, 9]))

    def score(gain: Array) -> float:
        return target.score(linear_law(gain), rows=ROWS, seed=seed)

    optimum = score(plain(read(target), target))
    still = target.score(still_law(len(target.bounds[0])), rows=ROWS, seed=seed)
    # One stream of transitions: more of them begin with the fewer.
    curves: dict[str, dict[str, float]] = {}
    stream = tried(target, max(counts), np.random.default_rng([seed, 5]))
    for count in counts:
        seen = Transitions(
            state=stream.state[:count],
            command=stream.command[:count],
            after=stream.after[:count],
            turns=stream.turns,
        )
        found = mapped(source, target, seen, seed=seed, controls=count == FEW)
        if kin is not None:
            close = seen_with(kin, noise)
            found |= from_kin(close, target, seen, seed=seed, controls=count == FEW)
        for name, gain in {**found, **sourceless(target, seen)}.items():
            curves.setdefault(name, {})[str(count)] = score(gain)
    took = {
        f"{size:g}": scratch(
            target, size=size, generations=generations, enough=ENOUGH * optimum, seed=seed
        )
        for size in (SIZES if generations else ())
    }
    return {
        "body": body, "seed": seed, "noise": noise, "oracle": optimum, "hold_still": still,
        "curves": curves, "scratch": took,
    }  # fmt: skip


Job = tuple[str, int, tuple[int, ...], int, float]
"""A body, a seed, counts of transitions, generations of learning from nothing, and the noise."""


def _job(told: Job) -> JSON:
    body, seed, counts, generations, noise = told
    return case(body, seed, counts=counts, generations=generations, noise=noise)


def first_enough(curve: dict[str, float], optimum: float) -> float:
    """Return from how many transitions on the score stays enough; infinity if it never does."""
    took = np.inf
    for count in sorted(curve, key=int, reverse=True):
        if curve[count] < ENOUGH * optimum:
            break
        took = float(count)
    return took


def summary(cases: list[JSON], generations: int) -> JSON:
    """Return the figures of both goals, with intervals over seeds within bodies."""
    bodies = sorted({each["body"] for each in cases})
    seeds = sorted({each["seed"] for each in cases})
    whole = {(each["body"], each["seed"]): each for each in cases}
    seeds = [seed for seed in seeds if all((body, seed) in whole for body in bodies)]
    names = [*MAPPED, *KIN, *SOURCELESS]

    def table(name: str, rows: list[str]) -> Array:
        return np.array(
            [
                [
                    whole[body, seed]["curves"][name][str(FEW)] / whole[body, seed]["oracle"]
                    for seed in seeds
                ]
                for body in rows
            ]
        )

    zero: JSON = {}
    for name in names:
        rows = [body for body in bodies if name in whole[body, seeds[0]]["curves"]]
        if not rows:
            continue
        scores = table(name, rows)
        zero[name] = {
            "iqm": iqm(scores),
            "interval": interval(scores),
            "bodies": {body: iqm(row) for body, row in zip(rows, scores, strict=True)},
            "solved": int(sum(iqm(row) >= ENOUGH for row in scores)),
        }
    counts = sorted(int(count) for count in cases[0]["curves"]["hop"])
    best = max(SOURCELESS, key=lambda name: _mean_of_curve(cases, name))
    with_kin = [body for body in bodies if body != HUMANOID]
    censored = 2 * counts[-1]
    return {
        "bodies": bodies,
        "seeds": seeds,
        "zero_shot": zero,
        "best_sourceless": best,
        "time_to_threshold": _times(whole, bodies, seeds, ("hop", best), censored, generations),
        "time_to_threshold_from_kin": _times(
            whole, with_kin, seeds, ("kin", best), censored, generations
        )
        if with_kin
        else None,
    }


def _mean_of_curve(cases: list[JSON], name: str) -> float:
    return float(np.mean([list(each["curves"][name].values()) for each in cases]))


def _times(
    whole: dict[tuple[str, int], JSON],
    bodies: list[str],
    seeds: list[int],
    ours_and_best: tuple[str, str],
    censored: int,
    generations: int,
) -> JSON:
    """Return times and how many times longer others take; a censored time is one grid step more.

    A ratio of two censored times is 1.
    """
    ours, best = ours_and_best
    said: JSON = {"censored_at": censored}
    times = {}
    for name in ours_and_best:
        rows = [
            [first_enough(whole[b, s]["curves"][name], whole[b, s]["oracle"]) for s in seeds]
            for b in bodies
        ]
        times[name] = np.array(rows)
        said[name] = {"solved": float(np.isfinite(times[name]).mean())}
        said[name]["bodies"] = {
            body: _said(iqm(np.minimum(row, censored)))
            for body, row in zip(bodies, times[name], strict=True)
        }
    soon = np.minimum(times[ours], censored)
    ratio = np.minimum(times[best], censored) / soon
    said["sourceless_over_ours"] = {"iqm": iqm(ratio), "interval": interval(ratio)}
    if generations:
        sizes = list(whole[bodies[0], seeds[0]]["scratch"])
        tuned, solved = [], []
        for body in bodies:
            by = np.array([[whole[body, s]["scratch"][size] for size in sizes] for s in seeds])
            # Of three sizes that which solves most, then soonest. What is unsolved counts by
            # what it used until then, which flatters it.
            at = int(np.lexsort((by[..., 0].mean(axis=0), -by[..., 1].mean(axis=0)))[0])
            tuned.append(by[:, at, 0])
            solved.append(by[:, at, 1])
        ratio = np.array(tuned) / soon
        said["scratch_over_ours"] = {"iqm": iqm(ratio), "interval": interval(ratio)}
        said["scratch_solved"] = float(np.mean(solved))
    return said


def _said(value: float) -> float | None:
    return value if np.isfinite(value) else None


def main(argv: list[str] | None = None) -> int:
    """Run the study."""
    told = _told(argv)
    low, _, high = told.seeds.rpartition(":")
    seeds = range(int(low or 0), int(high))
    bodies = told.bodies or list(BODIES)
    counts: tuple[int, ...] = (20, FEW) if told.quick else COUNTS
    generations = 0 if told.no_scratch or told.quick else told.generations
    kept = _kept(told.kept)
    kept = [each for each in kept if each["noise"] == told.noise]
    done = {(each["body"], each["seed"]) for each in kept}
    jobs = [
        (b, s, counts, generations, told.noise) for s in seeds for b in bodies if (b, s) not in done
    ]
    wanted = {(b, s) for s in seeds for b in bodies}
    cases = [each for each in kept if (each["body"], each["seed"]) in wanted]
    for each in _ran(jobs, told.workers):
        cases.append(each)
        print(f"{len(cases)}/{len(wanted)} {each['body']} {each['seed']}", file=sys.stderr)
        if told.kept:
            with told.kept.open("a", encoding="utf-8") as file:
                file.write(json.dumps(each) + "\n")
    said = {"summary": summary(cases, generations), "cases": cases}
    if told.json:
        told.json.write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(said["summary"], indent=1))
    return 0


def _ran(jobs: list[Job], workers: int) -> Iterator[JSON]:
    if workers <= 1:
        yield from map(_job, jobs)
        return
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ[name] = "1"
    with multiprocessing.get_context("spawn").Pool(workers) as pool:
        yield from pool.imap(_job, jobs)


def _kept(path: Path | None) -> list[JSON]:
    if path is None or not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines if line.endswith("}")]


def _told(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, epilog=EXAMPLE, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", default="0:10", help="A:B, or how many from 0")
    parser.add_argument("--bodies", nargs="+", choices=BODIES, help="all fifteen if none")
    parser.add_argument("--noise", type=float, default=0.0, help="of every reading")
    parser.add_argument("--json", type=Path, help="where to write every figure")
    parser.add_argument("--kept", type=Path, help="finished cases, one a line: goes on from there")
    parser.add_argument("--generations", type=int, default=3, help="of learning from nothing")
    parser.add_argument("--no-scratch", action="store_true", help="leave that out")
    parser.add_argument("--quick", action="store_true", help="two counts, nothing from nothing")
    parser.add_argument("--workers", type=int, default=2)
    return parser.parse_args(argv)


if __name__ == "__main__":
    raise SystemExit(main())
