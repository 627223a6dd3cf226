"""Whether plans made in a corrected simulator succeed on the cart-pole with concealed physics."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from experiments.residual import CASES, commands, concealed, figures_off, hypothesis_of
from experiments.transfer.changed import cartpole
from morph.arrays import JSON
from morph.model.missing_force.fit import fit
from morph.search.ddp import Plan
from morph.search.search import Problem
from morph.search.target import Simulated
from morph.sim.simulator import Simulator
from morph.sim.threads import one_thread
from morph.task.swing_up import swing_up
from morph.task.task import Task

RUNS = 2
"""Runs of 3 s with random commands that everything is learned from."""

TRIALS = 8
"""Trials of each plan on the target."""


def tried(case: str, seed: int) -> dict[str, JSON]:
    """Return what plans promise and what they do on one target, by where they were made."""
    rng = np.random.default_rng([seed, CASES.index(case), 1])
    task = swing_up(cartpole(figures_off(rng)))
    target = Simulated(task=task, simulator=task.simulator(concealed(case, rng)))
    runs = [target.trial(commands(rng), rng).run for _ in range(RUNS)]
    nominal, hypothesis = hypothesis_of()
    noise = np.full(4, task.noise)
    found: dict[str, JSON] = {}

    def add(name: str, planned: Task, simulator: Simulator, fitting: float) -> None:
        begun = time.process_time()
        learned = Plan().run(Problem(task=planned, simulator=simulator), seed=seed, trials=1)
        seconds = time.process_time() - begun
        trials = [target.trial(learned.policy, rng) for _ in range(TRIALS)]
        found[name] = {
            "promised": learned.trials[-1].loss,
            "loss": float(np.mean([trial.loss for trial in trials])),
            "success": float(np.mean([trial.success for trial in trials])),
            "seconds": fitting + seconds,
        }

    add("as described", nominal, nominal.simulator(), 0.0)
    for name, force in (("refitted", False), ("figures and force", True)):
        begun = time.process_time()
        model = fit(hypothesis, runs, noise=noise, force=force, integrator=task.integrator)
        fitting = time.process_time() - begun
        add(name, swing_up(model.robot), model.simulator, fitting)
        if force:
            turned = replace(model, weight=-model.weight)
            add("force turned round", swing_up(model.robot), turned.simulator, 0.0)
    add("the target itself", task, target.simulator, 0.0)
    return found


def table(results: dict[str, list[dict[str, JSON]]]) -> str:
    """Return medians over seeds and shares of successes as text."""
    lines = []
    for case, seeds in results.items():
        lines += [
            f"\nconcealed: {case} ({len(seeds)} seeds)",
            f"{'plan made in':22}{'promised':>10}{'loss':>8}{'success':>9}{'all':>6}{'s':>7}",
        ]
        for name in seeds[0]:
            each = [seed[name] for seed in seeds]
            promised, loss, seconds = (
                np.median([one[key] for one in each]) for key in ("promised", "loss", "seconds")
            )
            success = [one["success"] for one in each]
            every = sum(value == 1.0 for value in success)
            lines.append(
                f"{name:22}{promised:10.1f}{loss:8.1f}{np.mean(success):9.2f}"
                f"{every:6d}{seconds:7.1f}"
            )
    return "\n".join(lines)


def headline(results: dict[str, list[dict[str, JSON]]]) -> JSON:
    """Return what a result file holds: median losses and successes of each plan."""
    figures: JSON = {}
    controls: JSON = {}
    for case, seeds in results.items():
        for name in seeds[0]:
            each = [seed[name] for seed in seeds]
            told = {
                "loss": float(np.median([one["loss"] for one in each])),
                "success": float(np.mean([one["success"] for one in each])),
            }
            if name == "figures and force":
                figures |= {f"{case}_{key}": value for key, value in told.items()}
            else:
                controls[f"{case}_{figure_name(name)}"] = told
    rows = [
        {"case": case, "seed": at, "plan": name, "loss": one["loss"], "success": one["success"]}
        for case, seeds in results.items()
        for at, seed in enumerate(seeds)
        for name, one in seed.items()
    ]
    return {"figures": figures, "controls": controls, "rows": rows}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.residual_plans",
        description=(__doc__ or "").splitlines()[0],
        epilog="example: python -m experiments.residual_plans --seeds 100 110 --cases dry mixed",
    )
    parser.add_argument("--seeds", type=int, nargs=2, default=(100, 110), metavar=("FROM", "TO"))
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--json", type=Path, help="where to write what each plan did")
    parser.add_argument("--quick", action="store_true", help="one seed of one case")
    told, save = parse_and_save(parser, arguments, module="experiments.residual_plans")
    cases = ["dry"] if told.quick else told.cases
    seeds = range(100, 101) if told.quick else range(*told.seeds)
    results: dict[str, list[dict[str, JSON]]] = {}
    for seed in seeds:
        for case in cases:
            with one_thread():
                results.setdefault(case, []).append(tried(case, seed))
            ours = results[case][-1]["figures and force"]
            said = f"loss {ours['loss']:.1f}, success {ours['success']:.2f}"
            print(f"{case} {seed}: {said}", file=sys.stderr, flush=True)
            if told.json:
                told.json.parent.mkdir(parents=True, exist_ok=True)
                told.json.write_text(json.dumps(results, indent=1), encoding="utf-8")
    if save:
        save(**headline(results), seeds=seeds)
    print(table(results))


if __name__ == "__main__":
    main()
