"""A working policy for the first task of every body of the shelf, each by one `morph learn`.

Each command is printed as it can be typed; `--resume` goes on with a study that was stopped. One
body at a time is timed, unless `--workers` says otherwise.
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path

from rich.console import Console
from rich.table import Table

from experiments.engine_options import add_engine_options, rows_of
from experiments.figures.save_options import parse_and_save
from experiments.shelf_hold import SURE, held
from morph.arrays import JSON
from morph.body import shelf
from morph.body.load import load
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.shelf --out out/shelf
  python -m experiments.shelf --out out/shelf --only quadruped_printed sea_snake"""

COMMAND = "from morph.app.cli.main import entry; entry()"
"""The command `morph` of this very Python."""

MOST_SECONDS = 600.0
"""Longest that a body may take, s."""


def firsts(bodies: Iterable[str]) -> dict[str, str]:
    """Return the first task of each body's card, by the body; bodies without one are left out."""
    cards = {name: load(name).card for name in bodies if name in shelf.names()}
    return {name: card.tasks[0] for name, card in cards.items() if card is not None and card.tasks}


def learned(body: str, task: str, out: str, seed: int) -> JSON:
    """Return what one `morph learn` writes of itself, with its wall time, s.

    Its exit status is 3 if its policy does not do the task; that is a result like any other.
    """
    told = ["learn", task, "--robot", body, "--seed", str(seed), "--out", str(Path(out) / body)]
    print(f"morph {shlex.join(told)}", file=sys.stderr, flush=True)
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *told, "--json", "--quiet"],
        capture_output=True,
        text=True,
        check=False,
    )
    seconds = time.perf_counter() - began
    if done.returncode not in {0, 3}:
        return {"body": body, "task": task, "failed": done.stderr.strip(), "wall_s": seconds}
    record: JSON = json.loads(done.stdout)
    record["controls"]["posture held"] = held(body, task, seed)
    return {"body": body, "task": task, "wall_s": seconds, "record": record}


def works(row: JSON) -> bool:
    """Return whether a body has a policy that does its task, found in time."""
    found = "record" in row and row["record"]["succeeded"]
    return bool(found and row["wall_s"] <= MOST_SECONDS)


def without_policy(row: JSON) -> dict[str, float]:
    """Return the controls that do the task surely, by the share of runs in which they do."""
    controls = row["record"]["controls"]
    return {name: of["success"] for name, of in controls.items() if of["success"] >= SURE}


def is_learned(row: JSON) -> bool:
    """Return whether a body has a policy that works, for a task that no control does."""
    return works(row) and not without_policy(row)


def headline(rows: list[JSON]) -> JSON:
    """Return what a result file holds: bodies with a policy that works, beside doing nothing."""
    done = [row for row in rows if "record" in row]
    idle = [row["body"] for row in done if without_policy(row)]
    figures = {
        "bodies": len(rows),
        "working": sum(map(works, rows)),
        "longest_s": max(row["wall_s"] for row in rows),
        "least_success": min(row["record"]["judged"]["success"] for row in done),
        "learned": sum(map(is_learned, rows)),
        "done_without_a_policy": len(idle),
        "done_without_a_policy_by": ", ".join(idle) or "none",
    }
    short = [
        {
            "body": row["body"],
            "task": row["task"],
            "search": row["record"]["search"]["name"],
            "works": works(row),
            "learned": is_learned(row),
            "success": row["record"]["judged"]["success"],
            "loss": row["record"]["judged"]["loss"]["mean"],
            "wall_s": row["wall_s"],
        }
        for row in done
    ]
    controls = {
        row["body"]: {name: of["success"] for name, of in row["record"]["controls"].items()}
        for row in done
    }
    return {"figures": figures, "controls": controls, "rows": short}


def report(rows: list[JSON]) -> int:
    """Print a row a body, and return how many have a policy that works in time."""
    table = Table(title="First tasks of the shelf")
    titles = (
        "body",
        "task",
        "search",
        "works",
        "runs that succeed",
        "loss",
        "without a policy",
        "s",
    )
    for title in titles:
        table.add_column(title)
    working = 0
    for row in rows:
        if "failed" in row:
            table.add_row(row["body"], row["task"], "-", "no", row["failed"][:60], "", "", "")
            continue
        record = row["record"]
        fine = works(row)
        working += fine
        table.add_row(
            row["body"],
            row["task"],
            record["search"]["name"],
            "yes" if fine else "no",
            f"{record['judged']['success']:.0%}",
            f"{record['judged']['loss']['mean']:.3g}",
            ", ".join(f"{name} {of['success']:.0%}" for name, of in record["controls"].items()),
            f"{row['wall_s']:.0f}",
        )
    Console(width=150).print(table)
    learned_ones = sum(map(is_learned, rows))
    print(
        f"{working} of {len(rows)} bodies have a policy that does their first task; {learned_ones} "
        "of these are of tasks that no control does"
    )
    for row in rows:
        if "record" in row and without_policy(row):
            by = ", ".join(f"{name} {share:.0%}" for name, share in without_policy(row).items())
            print(f"not counted as learned: {row['body']}, {row['task']} ({by})")
    return working


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.shelf",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_engine_options(parser, out="out/shelf")
    parser.set_defaults(workers=1)
    parser.add_argument("--only", nargs="+", help="these bodies alone")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true", help="print JSON instead of words")
    asked, save = parse_and_save(parser, arguments, module="experiments.shelf")
    tasks = firsts(asked.only or shelf.names())
    bodies = asked.only or sorted(tasks)
    unknown = [body for body in bodies if body not in tasks]
    if unknown:
        print(f"no body of the shelf with a task: {', '.join(unknown)}", file=sys.stderr)
        return 2
    policies = str(asked.out / "policies")
    cases = [
        {"body": body, "task": tasks[body], "out": policies, "seed": asked.seed} for body in bodies
    ]
    rows = rows_of(cells_of(learned, cases), asked, name="shelf")
    if save:
        save(**headline(rows), seeds=[asked.seed])
    if asked.json:
        print(json.dumps(rows, indent=1))
    else:
        report(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
