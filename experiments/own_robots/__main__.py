"""Robots that nobody here wrote, through every command: a matrix of what works.

A cell works, is refused with a reason, stops short and says so, or fails: a bad message, a crash,
too long, or absurd (energy from nothing, a leap without power, a floor that is sunk into, a policy
worse than doing nothing called a success). Options that a message proposes are tried. Whether a
command applies is judged by a separate look at the tree, the feet and the motors.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.save_options import parse_and_save
from experiments.own_robots.drawn import drawn
from experiments.own_robots.matrix import COMMANDS, row
from experiments.own_robots.robots import ForeignRobot, foreign_robots
from morph.arrays import JSON
from morph.errors import MorphError
from morph.study.cell import cells_of

EXAMPLE = """examples:
  python -m experiments.own_robots --only packaged/go1 drawn/drawn_3 --save-as out/two.json
  python -m experiments.own_robots --commands inspect convert simulate --workers 2
  python -m experiments.own_robots --resume"""

FAILED = ("bad message", "crash", "too long", "absurd")
"""What must not be."""
LETTERS = {"works": "+", "refused": "r", "short": "s", "bad message": "M", "crash": "C"}
LETTERS |= {"too long": "T", "absurd": "A"}


def figures_of(rows: Sequence[JSON]) -> JSON:
    """Return how often commands work where they apply, and how often they fail, by command too."""
    cells = [(name, cell) for each in rows for name, cell in each["commands"].items()]
    kinds = Counter(cell["kind"] for _, cell in cells)
    fixed = [cell["fixed"] for _, cell in cells if "fixed" in cell]
    of = {name: Counter(c["kind"] for n, c in cells if n == name) for name in COMMANDS}
    return {
        "robots": len(rows),
        "cells": len(cells),
        "works": kinds["works"] / max(1, len(cells)),
        **{kind.replace(" ", "_"): kinds[kind] for kind in ("refused", "short", *FAILED)},
        "stand_pushed": sum(bool(cell.get("pushed")) for _, cell in cells)
        / max(1, of["stand"].total()),
        "in_time": sum(cell["in_time"] for _, cell in cells) / max(1, len(cells)),
        "fixes": len(fixed),
        "fixes_that_work": sum(kind in ("works", "short") for kind in fixed),
        **{
            f"{name}_works": counts["works"] / max(1, counts.total()) for name, counts in of.items()
        },
    }


def controls_of(rows: Sequence[JSON]) -> JSON:
    """Return how often doing nothing and random commands do what a policy learned to do."""
    learned = [
        cell["controls"]
        for each in rows
        for cell in each["commands"].values()
        if cell["kind"] == "works" and "controls" in cell
    ]
    return {
        name: {"success": sum(each[name]["success"] >= 0.5 for each in learned) / len(learned)}
        for name in (learned[0] if learned else ())
    }


def table_of(rows: Sequence[JSON]) -> Table:
    """Return the matrix: a row a robot, a letter a command, a blank where it does not apply."""
    table = Table(caption=", ".join(f"{mark} {kind}" for kind, mark in LETTERS.items()))
    for title in ("robot", *COMMANDS):
        table.add_column(title)
    for each in rows:
        cells = [each["commands"].get(name) for name in COMMANDS]
        marks = ["" if cell is None else LETTERS[cell["kind"]] for cell in cells]
        table.add_row(each["robot"], *marks)
    return table


def main(argv: list[str] | None = None) -> int:
    """Run the study and return its exit status: 1 if anything failed that must not."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.own_robots",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", nargs="+", help="these robots alone")
    parser.add_argument(
        "--commands", nargs="+", choices=COMMANDS, default=list(COMMANDS), metavar="NAME",
        help="these columns alone: " + ", ".join(COMMANDS),
    )  # fmt: skip
    parser.add_argument("--seeds", default="0:10", help="seeds of drawn robots: A:B, or how many")
    add_engine_options(parser, out="out/own_robots")
    asked, save = parse_and_save(parser, argv, module="experiments.own_robots")
    seeds, beside = seeds_of(asked.seeds), asked.out.with_name(f"{asked.out.name}_robots")
    try:
        robots = foreign_robots(beside / "wheels")
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    for seed in seeds:
        path = drawn(beside / "drawn", seed)
        robots.append(ForeignRobot(name=f"drawn/{path.stem}", path=path))
    names = {each.name for each in robots}
    if unknown := set(asked.only or ()) - names:
        sys.stderr.write(f"error: no such robot: {', '.join(sorted(unknown))}\n  fix: name one of ")
        sys.stderr.write(", ".join(sorted(names)) + "\n")
        return 2
    out = str((beside / "written").resolve())
    cases = [
        {
            "name": each.name,
            "path": str(each.path.resolve()),
            "out": out,
            "commands": asked.commands,
        }
        for each in robots
        if not asked.only or each.name in asked.only
    ]
    rows = rows_of(cells_of(row, cases), asked, name="own_robots")
    figures = figures_of(rows)
    console = Console(width=150)
    console.print(table_of(rows))
    for each in rows:
        for name, cell in each["commands"].items():
            if cell["kind"] in FAILED or cell.get("fixed") in ("refused", *FAILED):
                print(f"{each['robot']} {name}: {cell['kind']}: {cell['message'].strip()[-300:]}")
    print(json.dumps(figures, indent=1))
    if save:
        save(figures=figures, controls=controls_of(rows), rows=rows, seeds=list(seeds))
    return 1 if any(figures[kind.replace(" ", "_")] for kind in FAILED) else 0


if __name__ == "__main__":
    raise SystemExit(main())
