"""How well the cart-pole's balance policy serves many bodies, and how soon, from few transitions.

Told of a target: its transitions near rest, the noise and period, the bounds of its commands, and
which linear numbers of its state its task looks at. Judged runs begin with a push that no
transition shows. Beside the hop stand the map alone, wrong maps, what fits the target without
any source, learning from nothing, holding still, and the oracle on the true model.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.save_options import Save, parse_and_save
from experiments.morphologies.methods import from_kin, kin_of, mapped, sourceless
from experiments.morphologies.scratch import SIZES, scratch
from experiments.morphologies.summary import ENOUGH, FEW, HUMANOID, headline, in_words, summary
from morph.alignment.samples import Transitions
from morph.arrays import JSON, Array
from morph.policy_transfer.balancers import PLANAR, balancer, seen_with
from morph.policy_transfer.body import linear_law, still_law
from morph.policy_transfer.mapped.belief import read
from morph.policy_transfer.mapped.feedback import plain
from morph.policy_transfer.relay import tried
from morph.policy_transfer.riders import rider
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.zero_shot --seeds 0:10 --json out/zero_shot.json
  python -m experiments.zero_shot --seeds 0:10 --noise 0.001 --json out/zero_shot_noisy.json
  python -m experiments.zero_shot --seeds 100:102 --bodies cart_two_links --no-scratch"""

COUNTS = (2, 5, 10, 15, 20, 30, 60)
"""Transitions of the learning curves."""

ROWS = 2
"""Judged runs of every feedback."""


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


def main(argv: list[str] | None = None) -> int:
    """Run the study."""
    told, save = _told(argv)
    seeds = seeds_of(told.seeds)
    bodies = told.bodies or list(BODIES)
    counts: tuple[int, ...] = (20, FEW) if told.quick else COUNTS
    generations = 0 if told.no_scratch or told.quick else told.generations
    asked = [
        {"body": body, "seed": seed, "counts": counts, "generations": generations}
        | {"noise": told.noise}
        for seed in seeds
        for body in bodies
    ]
    cases = rows_of(cells_of(case, asked), told, name="zero_shot")
    said: JSON = {"summary": summary(cases, generations), "cases": cases}
    if save:
        save(**headline(said["summary"]), seeds=seeds)
    if told.json:
        told.json.write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(said["summary"], indent=1))
    print(f"noise {told.noise:g}: {in_words(said['summary'])}")
    return 0


def _told(argv: list[str] | None) -> tuple[argparse.Namespace, Save]:
    parser = argparse.ArgumentParser(
        prog="python -m experiments.zero_shot",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="0:10", help="A:B, or how many from 0")
    parser.add_argument("--bodies", nargs="+", choices=BODIES, help="all fifteen if none")
    parser.add_argument("--noise", type=float, default=0.0, help="of every reading")
    parser.add_argument("--json", type=Path, help="where to write every figure")
    parser.add_argument("--generations", type=int, default=3, help="of learning from nothing")
    parser.add_argument("--no-scratch", action="store_true", help="leave that out")
    parser.add_argument("--quick", action="store_true", help="two counts, nothing from nothing")
    add_engine_options(parser, out="out/zero_shot")
    return parse_and_save(parser, argv, module="experiments.zero_shot")


if __name__ == "__main__":
    raise SystemExit(main())
