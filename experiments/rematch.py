"""Policies of the shelf on bodies that weigh otherwise, as printing makes them: held or matched.

A policy is learned on the body as described. Then every link weighs otherwise, as the parts of a
printed SO-101 did: of its mass 0.4 to 1 is plastic, which weighs 0.5 to 0.9 of what was described;
its centre lies up to 6 mm off, and its second moments are 0.6 to 1.4 of what the mass alone would
make them; links of one role (both front legs) alike. `--masses parts` takes the masses that the
body's own parts have instead, estimated without a slicer, where the body can be divided.

Losses are means over noisy runs that chose nothing, paired: designed, unchanged on the printed
body, matched within 60 s, a fresh search there as long as it takes, and doing nothing. Growth is
in shares of the task's span. Seeds from 100 on served while building; 0 to 4 judge.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.result_file import flat
from experiments.figures.save_options import parse_and_save
from morph.arrays import JSON, Array
from morph.body.inertia import spread
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.roles import joint_roles
from morph.errors import MorphError
from morph.fabrication.link_mass import LinkMass
from morph.fabrication.match.case import Case as Judging
from morph.fabrication.printed import designed, printed_robot
from morph.fabrication.rematch import Matched, rematch
from morph.policy.policy import Policy
from morph.print.weight import Weight
from morph.search.search import Problem
from morph.search.searches import OTHERWISE, default, search
from morph.study.cell import cells_of
from morph.task.task import Task
from morph.task.tasks import task

EXAMPLE = """example:
  python -m experiments.rematch --resume
  python -m experiments.rematch --only cartpole:balance --seeds 100:101"""

CASES = (
    *("pendulum:swing-up", "pendulum:balance", "cartpole:swing-up", "cartpole:balance"),
    *("double_pendulum:swing-up", "double_pendulum:balance", "cart_two_links_servo:balance"),
    *("rider_rigid_driven:balance", "rider_rigid_driven:ride", "rider_two_links_passive:balance"),
    *("rider_three_links_driven:balance", "hopper:balance", "so101:reach", "biped:stand"),
    *("swimmer_three_links:swim", "quadruped_printed:walk", "quadruped_four_bar:walk"),
    "sea_snake:swim",
)
"""Bodies and what they do."""

SECONDS = 60.0
"""How long matching may take, s."""

PLASTIC, DENSITY, OFF, SPREAD = (0.4, 1.0), (0.5, 0.9), 0.006, (0.6, 1.4)
"""Share of a link that is plastic, its mass against the description's, how far its centre lies
off at most, m, and second moments against what the mass alone would make them."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """One body, one task, one seed."""

    body: str
    task: str
    seed: int
    masses: str


def weighed(robot: Robot, seed: int) -> Robot:
    """Return a robot whose links weigh otherwise, as printing makes them."""
    rng = np.random.default_rng([seed, 4])
    before = designed(robot)
    drawn: dict[str, tuple[float, Array, Array]] = {}
    masses, roles = [], joint_roles(robot)
    own_roles = {joint.link: roles.get(joint.name) for joint in robot.joints}
    for name in (link.name for link in robot.links):
        role = own.name if (own := own_roles.get(name)) else name
        if role not in drawn:
            share = rng.uniform(*PLASTIC)
            away = rng.normal(size=3)
            away *= rng.uniform(0.0, OFF) / np.linalg.norm(away)
            factor = 1.0 - share + share * rng.uniform(*DENSITY)
            drawn[role] = factor, away, rng.uniform(*SPREAD, 3)
        weight = before[name]
        if weight.mass > 0.0:
            mirror = np.array([1.0, -1.0 if own and own.side == 1.0 else 1.0, 1.0])
            masses.append(_mass(name, weight, drawn[role], mirror))
    return printed_robot(robot, masses)


def _mass(link: str, weight: Weight, drawn: tuple[float, Array, Array], mirror: Array) -> LinkMass:
    factor, away, wider = drawn
    # Scaled along the axes of the frame, second moments stay those of a body.
    scale = np.diag(np.sqrt(wider))
    moments = factor * scale @ spread(weight.inertia) @ scale
    now = Weight(
        mass=factor * weight.mass,
        com=weight.com + away * mirror,
        inertia=np.trace(moments) * np.eye(3) - moments,
    )
    return LinkMass(link=link, designed=weight, predicted=now, measured=None, source="estimate")


def of_parts(robot: Robot) -> Robot:
    """Return a robot with the masses of its own parts, estimated without a slicer."""
    from morph.fabrication.divide import divide
    from morph.fabrication.masses import link_masses
    from morph.print.prepare import prepare
    from morph.print.printer import Profile, material, printer

    profile = Profile(printer=printer("mk4"), material=material("pla"))
    division = divide(robot, profile)
    job = prepare(division.parts, division.hinges, profile, slicer=None, tell=lambda said: None)
    return printed_robot(robot, link_masses(robot, job, division.complete))


@lru_cache(maxsize=1)
def learned(body: str, what: str, seed: int) -> tuple[Task, Policy, float]:
    """Return a task, its policy as `morph learn` finds it, and the seconds that it took."""
    asked = task(what, load(body))
    begun = time.perf_counter()
    return asked, searched(asked, seed), time.perf_counter() - begun


def searched(asked: Task, seed: int) -> Policy:
    """Return what the task's own search finds."""
    problem = Problem(task=asked, simulator=asked.simulator())
    return search(default(asked.name, asked.robot))().run(problem, seed=seed).policy


def done(case: Case) -> JSON:
    """Return what a case shows, beside its controls."""
    # All seeds of a body begin with the policy of the first: what varies is the body.
    asked, policy, took = learned(case.body, case.task, 100 if case.seed >= 100 else 0)
    robot = weighed(asked.robot, case.seed) if case.masses == "drawn" else of_parts(asked.robot)
    found = rematch(policy, asked, robot, seconds=SECONDS, seed=case.seed)
    begun = time.perf_counter()
    fresh = None
    # A search by generations takes as long as all else: the first body of each has to do.
    if default(case.task, asked.robot) != OTHERWISE or case.seed % 100 == 0:
        with contextlib.suppress(MorphError):
            fresh = searched(found.task, case.seed)
    spent = time.perf_counter() - begun
    said: JSON = {
        "growth": found.unchanged.growth,
        "kept": found.kept.growth,
        "verdict": found.verdict,
        "by": found.by,
        "seconds": found.seconds,
        "runs": len(found.kept.printed.loss),
        "loss": {
            "designed": found.kept.designed.mean,
            "unchanged": found.unchanged.printed.mean,
            "matched": found.kept.printed.mean,
            "nothing": found.kept.still.mean,
        },
        "success": {
            "designed": found.kept.designed.share,
            "unchanged": found.unchanged.printed.share,
            "matched": found.kept.printed.share,
        },
        "mass": robot.mass / asked.robot.mass,
        "learned_s": took,
        "fresh_s": spent,
    }
    if fresh is not None:
        score = _judged(case, asked, policy, found, fresh)
        said["loss"]["fresh"], said["success"]["fresh"] = score
    return said


def _judged(
    case: Case, asked: Task, policy: Policy, found: Matched, fresh: Policy
) -> tuple[float, float]:
    """Return loss and success of another policy in the very runs that judged."""
    bench = Judging(
        policy=policy,
        learned=policy,
        designed=asked,
        printed=found.task,
        seconds=SECONDS,
        seed=case.seed,
    )
    score = bench.judged(fresh, rows=len(found.kept.printed.loss))
    return score.mean, score.share


def report(cases: Sequence[Case], rows: Sequence[JSON]) -> None:
    """Print a line for each body and task."""
    table = Table(title="Policies on printed bodies")
    heads = ("task", "masses", "verdicts", "growth unchanged", "kept", "success", "", "loss", "s")
    for head in heads:
        table.add_column(head)
    kinds = dict.fromkeys((case.body, case.task, case.masses) for case in cases)
    for kind in kinds:
        those = [
            row
            for case, row in zip(cases, rows, strict=True)
            if (case.body, case.task, case.masses) == kind
        ]
        table.add_row(*_cells(kind, those))
    Console(width=190).print(table)
    told = headline(rows)["figures"]
    print(
        f"{told['within']} of {len(rows)} end within 2 % of the span, {told['unchanged_within']} "
        f"of them unchanged; the slowest took {told['slowest_s']:.1f} s"
    )


def headline(rows: Sequence[JSON]) -> JSON:
    """Return what a result file holds: how many policies hold on the printed bodies."""
    figures = {
        "cases": len(rows),
        "within": sum(row["verdict"] != "lost" for row in rows),
        "unchanged_within": sum(row["growth"] <= 0.02 and _steady(row) for row in rows),
        "matched": sum(row["by"] != "unchanged" for row in rows),
        "worst_growth_percent": 100.0 * max(row["kept"] for row in rows),
        "slowest_s": max(row["seconds"] for row in rows),
    }
    unchanged = {"worst_growth_percent": 100.0 * max(row["growth"] for row in rows)}
    return {"figures": figures, "controls": {"unchanged": unchanged}}


def _steady(row: JSON) -> bool:
    return bool(row["success"]["unchanged"] >= row["success"]["designed"] - 0.02)


def _cells(kind: tuple[str, str, str], rows: Sequence[JSON]) -> tuple[str, ...]:
    body, what, masses = kind
    verdicts = [row["verdict"] for row in rows]
    counted = ", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts))
    ways = ", ".join(dict.fromkeys(row["by"] for row in rows if row["by"] != "unchanged"))
    losses = " ".join(
        f"{name} {np.mean([row['loss'][name] for row in rows if name in row['loss']]):.3g}"
        for name in ("designed", "unchanged", "matched", "fresh", "nothing")
        if any(name in row["loss"] for row in rows)
    )
    shares = "/".join(
        f"{np.mean([row['success'][name] for row in rows]):.2f}"
        for name in ("designed", "unchanged", "matched")
    )
    return (
        f"{body} {what}",
        f"{masses} {np.mean([row['mass'] for row in rows]):.2f}",
        counted,
        f"{100 * np.mean([row['growth'] for row in rows]):+.2f} %",
        f"{100 * np.mean([row['kept'] for row in rows]):+.2f} %",
        shares,
        ways,
        losses,
        "{:.0f} (fresh {:.0f})".format(
            *(max(row[name] for row in rows) for name in ("seconds", "fresh_s"))
        ),
    )


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.rematch",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="0:5", help="from:to, the last not among them")
    parser.add_argument("--only", nargs="+", metavar="BODY:TASK", help="these alone")
    parser.add_argument("--masses", choices=("drawn", "parts"), default="drawn")
    add_engine_options(parser, out="out/rematch")
    asked, save = parse_and_save(parser, arguments, module="experiments.rematch")
    unknown = [each for each in asked.only or () if ":" not in each]
    if unknown:
        print(f"write BODY:TASK, not {', '.join(unknown)}", file=sys.stderr)
        return 2
    cases = [
        Case(body=body, task=what, seed=seed, masses=asked.masses)
        for body, _, what in (each.partition(":") for each in asked.only or CASES)
        for seed in seeds_of(asked.seeds)
    ]
    rows = rows_of(cells_of(done, cases), asked, name="rematch")
    if save:
        whole = [asdict(case) | flat(row) for case, row in zip(cases, rows, strict=True)]
        save(**headline(rows), rows=whole, seeds=sorted({case.seed for case in cases}))
    report(cases, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
