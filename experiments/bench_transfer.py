"""First-trial transfer in figures: the loop beside adjusting, doing nothing, and the oracle.

A policy is planned on a body as described and tried on one that was changed: a figure of it, or
physics that its description does not have. The loop (`morph/policy_transfer/loop.py`) has some
trials on the target. Beside it: adjusting alone (thesis 3.3), learning from scratch on the target,
the policy as it is, and a plan on the true body. Every policy is judged by 64 noisy runs that
nobody learns from. The seeds 0 to 19 judge; all was built on seeds from 100 on.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console

from experiments.engine_options import add_engine_options, rows_of
from experiments.figures.save_options import parse_and_save
from experiments.transfer.cases import Case
from experiments.transfer.changed import FIGURES
from experiments.transfer.headline import headline
from experiments.transfer.job import Job, work
from experiments.transfer.tables import compared, figure8, harm, missed, summary
from morph.arrays import JSON
from morph.body.load import load
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.bench_transfer --only friction --seeds 20 --resume
  python -m experiments.bench_transfer --only figure8 --seeds 10 --plot out/figure8.html
  python -m experiments.bench_transfer --quick"""

FRICTION = (3.0, 11.0)
"""Friction +200 % and +1000 %."""

BODIES = (("l", (0.5, 0.7, 1.5, 2.0)), ("m", (0.5, 2.0, 4.0)), ("M", (0.5, 2.0, 4.0)))
"""Pole lengths and masses of the issue's second goal."""

FACTORS = (0.25, 0.5, 2.0, 4.0, 10.0)
"""Factors of each of the five parameters of figures 7 and 8."""

BEYOND, FARTHEST, FEW = 4.0, 10.0, 3
"""Factors from which most targets are beyond their motors, and how many seeds such a one gets."""

WIDE = math.sqrt(0.1)
"""Standard deviation of every number of the start in figure 8, whose variance is 0.1."""

STRENGTHS = {
    "armature": (0.3, 0.01, 0.02),
    "coulomb_friction": (1.0, 0.03, 0.2),
    "joint_stiffness": (2.0, 0.05, 0.3),
    "quadratic_damping": (0.5, 0.005, 0.02),
    "stribeck_friction": (1.0, 0.03, 0.2),
    "viscous_friction": (1.0, 0.02, 0.1),
    "actuator_delay": (0.04, 0.04, 0.03),
    "actuator_lag": (0.05, 0.05, 0.05),
    "torque_scale": (0.7, 0.7, 0.6),
}
"""Strength of each concealed effect: on the cart's slide, on its pole, on the double pendulum."""


def friction(seeds: Sequence[int]) -> list[Job]:
    """Return the jobs of more friction: success in the first trial after one run."""
    arms = ("loop", "unadjusted", "own plan")
    cases = [Case(body="cartpole", figures={"damping:slide": each}) for each in FRICTION]
    return [_job(case, arm, seed, 2) for case in cases for arm in arms for seed in seeds]


def bodies(seeds: Sequence[int]) -> list[Job]:
    """Return the jobs of other lengths and masses: success within two trials in all."""
    return [
        _job(Case(body="cartpole", figures={FIGURES[name]: factor}), arm, seed, 2)
        for seed in seeds
        for name, factors in BODIES
        for factor in factors
        for arm in ("loop", "unadjusted", "own plan")
        if factor < BEYOND or seed < seeds[0] + FEW
    ]


def figures78(seeds: Sequence[int]) -> list[Job]:
    """Return the jobs of figures 7 and 8: five parameters, five factors, three trials."""
    jobs = []
    for seed in seeds:
        few = seed < seeds[0] + FEW
        jobs.append(_job(Case(body="cartpole", spread=WIDE), "unadjusted", seed, 5))
        for figure in FIGURES.values():
            for factor in FACTORS:
                case = Case(body="cartpole", figures={figure: factor}, spread=WIDE)
                arms = ["unadjusted"]
                arms += ["loop"] if few or factor < FARTHEST else []
                arms += ["adjusted", "own plan"] if few else []
                jobs += [_job(case, arm, seed, 3) for arm in arms]
    return jobs


def concealed(seeds: Sequence[int]) -> list[Job]:
    """Return the jobs of physics that the description does not have."""
    cases = []
    for body in ("cartpole", "double_pendulum"):
        robot = load(body)
        motors = [each.name for each in robot.actuators]
        for name, (slide, pole, pendulum) in STRENGTHS.items():
            acts = name.startswith(("actuator", "torque"))
            for place in motors if acts else [joint.name for joint in robot.joints]:
                here = {"slide": slide, "hinge": pole}
                value = here[place] if body == "cartpole" else pendulum
                cases.append(Case(body=body, effects=((name, place, value),)))
    arms = ("loop", "adjusted", "unadjusted", "own plan")
    return [
        _job(case, arm, seed, 3)
        for seed in seeds
        for case in cases
        for arm in arms
        if arm in {"loop", "unadjusted"} or seed == seeds[0]
    ]


def scratch(seeds: Sequence[int]) -> list[Job]:
    """Return the jobs of learning from scratch on the target, five trials."""
    named = (("l", 2.0), ("l", 0.5), ("m", 0.5), ("M", 2.0), ("b", 11.0), ("g", 0.5))
    cases = [Case(body="cartpole", figures={FIGURES[name]: factor}) for name, factor in named]
    return [
        _job(case, arm, seed, 5) for case in cases for arm in ("scratch", "loop") for seed in seeds
    ]


def _job(case: Case, arm: str, seed: int, trials: int) -> Job:
    return Job(case=case, arm=arm, seed=seed, trials=trials)


PARTS: dict[str, Callable[[Sequence[int]], list[Job]]] = {
    "friction": friction,
    "bodies": bodies,
    "figure8": figures78,
    "concealed": concealed,
    "scratch": scratch,
}
"""What may be asked for."""


def main(arguments: list[str] | None = None) -> int:
    """Run what is asked for, and print a table."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bench_transfer",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", nargs="+", choices=list(PARTS), default=list(PARTS))
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", type=int, default=20, help="how many")
    add_engine_options(parser, out="out/bench_transfer")
    parser.add_argument("--plot", type=Path, help="figure 8 as a page")
    parser.add_argument("--json", action="store_true", help="print everything as JSON")
    parser.add_argument("--quick", action="store_true", help="one case, to see that it works")
    asked, save = parse_and_save(parser, arguments, module="experiments.bench_transfer")
    seeds = range(asked.seed, asked.seed + asked.seeds)
    jobs = [job for name in asked.only for job in PARTS[name](list(seeds))]
    if asked.quick:
        jobs = [each for each in friction([100]) if "x11" in each.case.name]
    lines = rows_of(cells_of(work, jobs), asked, name="bench_transfer")
    if save:
        save(**headline(lines), seeds=seeds)
    if asked.json:
        print(json.dumps(lines))
        return 0
    shown(lines)
    if asked.plot is not None:
        asked.plot.write_text(figure8(lines))
    return 0


def shown(lines: list[JSON]) -> None:
    """Print the tables."""
    console = Console(width=150)
    console.print(summary(lines))
    console.print(harm(lines))
    both = compared(lines)
    failed = missed(lines)
    console.print(
        f"the oracle (a plan on the true body) works and the loop's policy does not: "
        f"{len(failed)} of {both} cases in which both were run"
    )
    for each in failed:
        console.print(
            f"  {each['case']}, seed {each['seed']}: the loop {each['loop_success']:.0%} of runs, "
            f"loss {each['loop_loss']:.1f}; the oracle {each['oracle_success']:.0%}, "
            f"{each['oracle_loss']:.1f}"
        )


if __name__ == "__main__":
    sys.exit(main())
