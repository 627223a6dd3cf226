"""A working policy for the first task of every body of the shelf, each by one `morph learn`.

Each command is printed as it can be typed. What is in the folder already is not made again, so
that a study that was stopped goes on.
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from morph.arrays import JSON
from morph.body import shelf
from morph.body.load import load

EXAMPLE = """example:
  python -m experiments.shelf --out out/shelf
  python -m experiments.shelf --out out/shelf --only quadruped_printed sea_snake"""

COMMAND = "from morph.app.cli.main import entry; entry()"
"""The command `morph` of this very Python."""

MOST_SECONDS = 600.0
"""Longest that a body may take, s."""


def firsts() -> dict[str, str]:
    """Return the first task of each body's card, by the body."""
    tasks = {name: load(name).card for name in shelf.names()}
    return {name: card.tasks[0] for name, card in tasks.items() if card is not None and card.tasks}


def learned(body: str, task: str, out: Path, *, seed: int) -> JSON:
    """Return what one `morph learn` writes of itself, with its wall time, s.

    Its exit status is 3 if its policy does not do the task; that is a result like any other.
    """
    told = ["learn", task, "--robot", body, "--seed", str(seed), "--out", str(out / body)]
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
    return {"body": body, "task": task, "wall_s": seconds, "record": record}


def kept(body: str, task: str, out: Path, *, seed: int) -> JSON:
    """Return the result of a body, made now or kept from an earlier run of the study."""
    path = out / f"{body}.json"
    if path.is_file():
        found: JSON = json.loads(path.read_text(encoding="utf-8"))
        return found
    found = learned(body, task, out, seed=seed)
    path.write_text(json.dumps(found), encoding="utf-8")
    return found


def report(rows: list[JSON]) -> int:
    """Print a row a body, and return how many have a policy that works in time."""
    table = Table(title="First tasks of the shelf")
    for title in ("body", "task", "search", "works", "runs that succeed", "loss", "nothing", "s"):
        table.add_column(title)
    working = 0
    for row in rows:
        if "failed" in row:
            table.add_row(row["body"], row["task"], "-", "no", row["failed"][:60], "", "", "")
            continue
        record = row["record"]
        fine = record["succeeded"] and row["wall_s"] <= MOST_SECONDS
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
    print(f"{working} of {len(rows)} bodies have a policy that does their first task")
    return working


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.shelf",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--out", default="out/shelf", help="folder of the policies")
    parser.add_argument("--only", nargs="+", help="these bodies alone")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true", help="print JSON instead of words")
    asked = parser.parse_args(arguments)
    out = Path(asked.out)
    out.mkdir(parents=True, exist_ok=True)
    tasks = firsts()
    bodies = asked.only or sorted(tasks)
    unknown = [body for body in bodies if body not in tasks]
    if unknown:
        print(f"no body of the shelf with a task: {', '.join(unknown)}", file=sys.stderr)
        return 2
    try:
        rows = [kept(body, tasks[body], out, seed=asked.seed) for body in bodies]
    except KeyboardInterrupt:
        return 130
    if asked.json:
        print(json.dumps(rows, indent=1))
    else:
        report(rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
