"""Every body of the shelf made into parts, looked at by the gate, turned, weighed and laid out.

A body is divided as `morph print` does it. Without `--slice` masses and hours are estimated; with
it PrusaSlicer is asked for every part, which takes minutes a body.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from experiments.figures.save_options import parse_and_save
from morph.arrays import JSON
from morph.body import shelf
from morph.body.load import load
from morph.errors import MorphError
from morph.fabrication.divide import divide
from morph.files import write_whole
from morph.print.errors import PrintError
from morph.print.job import Job
from morph.print.part import Check
from morph.print.prepare import prepare
from morph.print.printer import Profile, material, printer
from morph.print.slicer import Slicer, find_slicer

EXAMPLE = """example:
  python -m experiments.print_shelf
  python -m experiments.print_shelf humanoid quadruped_four_bar --slice --out out/print_shelf.json
"""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One body."""

    body: str
    """Its name."""
    parts: int
    """Printed parts that differ, pieces of what was cut counted."""
    copies: int
    """Printed parts with all their copies."""
    plates: int
    """Plates without the gauges'."""
    refused: tuple[str, ...]
    """Each part or joint that was refused, and why."""
    warnings: tuple[str, ...]
    """What the slicer warned of."""
    grams: float
    """Plastic that stays."""
    support_grams: float
    """Plastic that is thrown away."""
    hours: float
    """Time of the printer, one part at a time."""
    seconds: float
    """Wall time of all of it."""
    error: str = ""
    """Why there is no job."""


def row(body: str, profile: Profile, slicer: Slicer | None) -> Row:
    """Return what becomes of one body."""
    began = time.perf_counter()
    try:
        found = divide(load(body), profile)
        job = prepare(found.parts, found.hinges, profile, slicer=slicer)
    except (MorphError, PrintError) as error:
        return _failed(body, error, time.perf_counter() - began)
    printed = [part for part in job.parts if part.name in job.sliced]
    support = sum(job.sliced[part.name].support_kg * part.count for part in printed)
    return Row(
        body=body,
        parts=len(printed),
        copies=sum(part.count for part in printed),
        plates=sum(plate.name.startswith("plate") for plate in job.plates),
        refused=_refused((*found.checks, *job.checks)),
        warnings=_warnings(job),
        grams=job.grams,
        support_grams=1e3 * support,
        hours=job.seconds / 3600.0,
        seconds=time.perf_counter() - began,
    )


def _failed(body: str, error: Exception, seconds: float) -> Row:
    return Row(
        body=body,
        parts=0,
        copies=0,
        plates=0,
        refused=(),
        warnings=(),
        grams=0.0,
        support_grams=0.0,
        hours=0.0,
        seconds=seconds,
        error=str(error).splitlines()[0],
    )


def _refused(checks: Sequence[Check]) -> tuple[str, ...]:
    return tuple(
        f"{check.part}, {check.name}: {check.what}"
        for check in checks
        if check.verdict == "refused"
    )


def _warnings(job: Job) -> tuple[str, ...]:
    return tuple(
        f"{name}: {warning}" for name, sliced in job.sliced.items() for warning in sliced.warnings
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.print_shelf",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bodies", nargs="*", help="bodies of the shelf; by default all")
    parser.add_argument("--printer", default="mk4", help="the printer")
    parser.add_argument("--material", default="pla", help="the plastic")
    parser.add_argument("--slice", action="store_true", help="ask PrusaSlicer for every part")
    parser.add_argument("--out", type=Path, help="write the rows to this file as JSON")
    asked, save = parse_and_save(parser, arguments, module="experiments.print_shelf")
    profile = Profile(printer=printer(asked.printer), material=material(asked.material))
    slicer = find_slicer() if asked.slice else None
    if asked.slice and slicer is None:
        parser.error("there is no prusa-slicer here; install it, or leave out --slice")
    rows = []
    for body in asked.bodies or shelf.names():
        print(body, file=sys.stderr, flush=True)
        rows.append(row(body, profile, slicer))
        if asked.out is not None:
            write_whole(asked.out, json.dumps([asdict(each) for each in rows], indent=1))
    if save:
        save(**headline(rows))
    _show(rows)
    return 0


def headline(rows: Sequence[Row]) -> JSON:
    """Return what a result file holds: how many bodies can be printed, and what they take."""
    fine = [row for row in rows if not row.error and not row.refused]
    figures: JSON = {"bodies": len(rows), "without_refusal": len(fine)}
    figures["without_warning"] = sum(not row.warnings for row in fine)
    for row in rows:
        own = {"grams": row.grams, "hours": row.hours, "copies": row.copies}
        figures |= {f"{row.body}_{key}": value for key, value in own.items()}
    # Its parts that the gate refuses are not sliced, so nothing is known of what it would say.
    alone = sum(not row.error and not row.warnings for row in rows)
    controls = {"the slicer's warnings instead of the gate": {"without_warning": alone}}
    return {"figures": figures, "controls": controls, "rows": [asdict(row) for row in rows]}


def _show(rows: Sequence[Row]) -> None:
    table = Table("body", "parts", "copies", "plates", "refused", "warnings")
    for title in ("g", "support g", "h", "s"):
        table.add_column(title, justify="right")
    for each in rows:
        table.add_row(
            each.body,
            *(str(number) for number in (each.parts, each.copies, each.plates)),
            each.error or str(len(each.refused)),
            str(len(each.warnings)),
            f"{each.grams:.0f}",
            f"{each.support_grams:.0f}",
            f"{each.hours:.1f}",
            f"{each.seconds:.0f}",
        )
    console = Console(width=120)
    console.print(table)
    for each in rows:
        for what in (*each.refused, *each.warnings):
            console.print(f"{each.body}: {what}", markup=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
