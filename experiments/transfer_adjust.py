"""Policy adjustment in figures: one run of the source's policy, and then the first trial.

The source is the cart-pole of the thesis, the target the same with one of its five parameters
multiplied. The source's plan runs on the target once; inverse dynamics are learned from that run,
the policy is adjusted, and runs again: the first trial. What is said of it: whether it succeeds,
what it costs, and how many of further noisy runs succeed. Beside it stand the policy as it was,
and controls: the same with the run's commands shuffled, with the adjustment's sign turned, and
with the target's true inverse dynamics in place of learned ones (oracle). `plain` adjusts the
plan that ran; `adjusted` may take another plan of the source that leaves its commands more room.

The seeds 0 to 19 judge; all was built on seeds from 100 on.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from experiments.transfer.changed import cartpole, changed, target_of
from morph.alignment.inverse import Inverse
from morph.arrays import JSON, Array
from morph.errors import MorphError
from morph.policy.adjusted import Adjusted
from morph.policy.policy import Policy
from morph.policy_transfer.adjustment import adjust
from morph.policy_transfer.adjustment.adjust import AdjustedPolicy, AdjustSettings
from morph.policy_transfer.adjustment.adjusted_rollout import most_promising
from morph.policy_transfer.adjustment.rounds import sources
from morph.policy_transfer.adjustment.source import SimulatedTask
from morph.search.evaluate import evaluate
from morph.search.target import Experience, Simulated
from morph.sim.threads import one_thread
from morph.task.swing_up import swing_up

EXAMPLE = """example:
  python -m experiments.transfer_adjust --only friction --seed 100 --seeds 5 --save-as friction.json
"""

FRICTION = (("b", 3.0), ("b", 11.0))
"""Friction +200 % and +1000 %."""
FACTORS = (0.25, 0.5, 2.0, 4.0, 10.0)
"""Factors of each parameter, as in figures 7 and 8 of the thesis."""
FIGURE = tuple((name, factor) for name in ("g", "l", "m", "M", "b") for factor in FACTORS)
"""Every parameter by every factor."""
ROWS = 30
"""Noisy runs by which each policy is judged beside its first trial."""

WAYS: dict[str, AdjustSettings] = {
    "local": AdjustSettings(inverse="local"),
    "without a guess": AdjustSettings(guessed=False),
    "starts: source": AdjustSettings(starts="source"),
    "starts: target": AdjustSettings(starts="target"),
}
"""Other ways to adjust, compared on the friction."""


class Known(Inverse):
    """The inverse dynamics of the target itself, which no transfer knows."""

    def __init__(self, target: Simulated) -> None:
        self._source = SimulatedTask(task=target.task, simulator=target.simulator)

    def predict(self, state: Array, after: Array) -> tuple[Array, Array]:
        """Return the command that leads nearest, without doubt."""
        found = self._source.inverse(state, after)
        return found, np.zeros_like(found)


@dataclass(frozen=True, kw_only=True)
class Tried:
    """How one policy does on the target."""

    success: bool
    """Whether its first trial reached every goal."""
    loss: float
    """What its first trial cost."""
    share: float
    """Share of further noisy runs that reach every goal."""
    mean: float
    """What these cost on average."""
    seconds: float = 0.0
    """Wall time from the run to the policy, s."""


class Case:
    """One seed on one target: the run of the source's policy, and all that is made of it."""

    def __init__(
        self, source: SimulatedTask, plans: Sequence[Policy], target: Simulated, seed: int
    ):
        self.source, self.plans, self.target, self.seed = source, plans, target, seed
        self.run = target.trial(plans[0], np.random.default_rng([seed, 1]))

    def tried(self, policy: Policy, seconds: float = 0.0) -> Tried:
        """Return how a policy does; every policy meets the same starts and the same noise."""
        shown = self.target.trial(policy, np.random.default_rng([self.seed, 2]))
        score = evaluate(
            self.target.task,
            policy,
            self.target.simulator,
            rng=np.random.default_rng([self.seed, 3]),
            rows=ROWS,
        )
        return Tried(
            success=shown.success,
            loss=shown.loss,
            share=score.share,
            mean=score.mean,
            seconds=seconds,
        )

    def made(
        self,
        run: Experience | None = None,
        *,
        settings: AdjustSettings | None = None,
        inverse: Inverse | None = None,
    ) -> AdjustedPolicy:
        """Return what is made of one run."""
        return adjust.adjusted(
            self.source,
            self.plans[0],
            [run or self.run],
            rng=np.random.default_rng([self.seed, 4]),
            settings=settings,
            inverse=inverse,
        )

    def chosen(self, made: AdjustedPolicy) -> Adjusted:
        """Return the plan of the source that promises most under an adjustment."""
        rng = np.random.default_rng([self.seed, 5])
        return most_promising(self.source, made.adjustment, self.plans, rng=rng)[0]

    def found(self, *, controls: bool) -> JSON:
        """Return how everything does that is to be compared, by name."""
        began = time.perf_counter()
        made = self.made()
        policy = self.chosen(made)
        seconds = time.perf_counter() - began
        ways = {
            "none": self.tried(self.plans[0]),
            "plain": self.tried(made.policy),
            "adjusted": self.tried(policy, seconds),
            "roomy": self.tried(self.plans[1]),
        }
        if controls:
            rng = np.random.default_rng([self.seed, 6])
            mixed = replace(self.run, command=rng.permutation(self.run.command))
            flipped = adjust.applied(made.adjustment.times(-1.0), policy.source)
            ways["shuffled"] = self.tried(self.chosen(self.made(mixed)))
            ways["flipped"] = self.tried(flipped)
            ways["oracle"] = self.tried(self.chosen(self.made(inverse=Known(self.target))))
        return {
            "seed": self.seed,
            "plan": [each is policy.source for each in self.plans].index(True),
            "followed": made.followed.share,
            "beyond": made.beyond,
            "ways": {name: vars(each) for name, each in ways.items()},
        }


def measured(
    cases: Sequence[tuple[str, float]], seeds: range, *, controls: bool, ways: bool = False
) -> JSON:
    """Return every case over every seed."""
    task = swing_up(cartpole())
    source = SimulatedTask(task=task, simulator=task.simulator())
    targets = {case: target_of(changed(*case)) for case in cases}
    found: dict[tuple[str, float], list[JSON]] = {case: [] for case in cases}
    planning = []
    for seed in seeds:
        print(f"seed {seed}: plans of the source ...", file=sys.stderr, flush=True)
        began = time.perf_counter()
        plans = sources(source, seed=seed)
        planning.append(time.perf_counter() - began)
        for case, target in targets.items():
            with one_thread():
                one = Case(source, plans, target, seed)
                row = one.found(controls=controls)
                for name, settings in WAYS.items() if ways else ():
                    policy = one.chosen(one.made(settings=settings))
                    row["ways"][name] = vars(one.tried(policy))
            found[case].append(row)
    rows = [_summary(*case, runs) for case, runs in found.items()]
    return {"planning_s": float(np.median(planning)), "cases": rows}


def _summary(name: str, factor: float, runs: list[JSON]) -> JSON:
    by: JSON = {
        "success": np.mean,
        "loss": np.median,
        "share": np.mean,
        "mean": np.median,
    }
    ways = {
        way: {key: float(of([run["ways"][way][key] for run in runs])) for key, of in by.items()}
        for way in runs[0]["ways"]
    }
    seconds = [run["ways"]["adjusted"]["seconds"] for run in runs]
    followed = {
        look: float(np.mean([run["followed"][look] for run in runs]))
        for look in runs[0]["followed"]
    }
    return {
        "parameter": name,
        "factor": factor,
        "seeds": len(runs),
        "ways": ways,
        "seconds": {"median": float(np.median(seconds)), "worst": max(seconds)},
        "followed": followed,
        "beyond": float(np.median([run["beyond"] for run in runs])),
        "runs": runs,
    }


def report(found: JSON) -> None:
    """Print the figures as tables."""
    console = Console(width=160)
    for part in ("friction", "figure"):
        if part not in found:
            continue
        cases = found[part]["cases"]
        names = list(cases[0]["ways"])
        table = Table(
            title=f"{part}: first trials that succeed, of {cases[0]['seeds']} (mean loss)"
        )
        for title in ("case", *names, "followed", "beyond", "worst s"):
            table.add_column(title, justify="left" if title == "case" else "right")
        for row in cases:
            each = [
                f"{round(way['success'] * row['seeds'])} ({way['mean']:.1f})"
                for way in row["ways"].values()
            ]
            looks = "/".join(f"{share:.2f}" for share in row["followed"].values())
            last = (looks, f"{row['beyond']:.1f}", f"{row['seconds']['worst']:.2f}")
            table.add_row(f"{row['parameter']} x{row['factor']:g}", *each, *last)
        console.print(table)
        print(f"plans of the source: {found[part]['planning_s']:.1f} s, median of seeds")


def headline(found: JSON) -> JSON:
    """Return what a result file holds: first trials that succeed, and losses, by case and way."""
    cases = [row for part in ("friction", "figure") for row in found.get(part, {}).get("cases", [])]
    figures: JSON = {}
    controls: JSON = {}
    for row in cases:
        case = figure_name(f"{row['parameter']} x{row['factor']:g}")
        for way, told in row["ways"].items():
            if way == "adjusted":
                figures |= {f"{case}_{key}": value for key, value in told.items()}
            else:
                controls[f"{case}_{figure_name(way)}"] = told
        figures |= {f"{case}_{key}_seconds": value for key, value in row["seconds"].items()}
    rows = [{key: value for key, value in row.items() if key != "runs"} for row in cases]
    return {"figures": figures, "controls": controls, "rows": rows, "seeds": found["seeds"]}


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.transfer_adjust",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", choices=("friction", "figure"), help="this part alone")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", type=int, default=20, help="how many seeds")
    parser.add_argument("--ways", action="store_true", help="compare other ways to adjust, too")
    parser.add_argument("--quick", action="store_true", help="one seed, two cases")
    asked, save = parse_and_save(parser, arguments, module="experiments.transfer_adjust")
    seeds = range(asked.seed, asked.seed + (1 if asked.quick else max(1, asked.seeds)))
    found: JSON = {"schema": "morph.transfer_adjust/1", "seeds": list(seeds)}
    try:
        if asked.only != "figure":
            found["friction"] = measured(FRICTION, seeds, controls=True, ways=asked.ways)
        if asked.only != "friction" and not asked.quick:
            found["figure"] = measured(FIGURE, seeds, controls=False)
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if save:
        save(**headline(found))
    report(found)
    return 0


if __name__ == "__main__":
    sys.exit(main())
