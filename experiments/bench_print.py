"""How long `morph print` takes: the whole command, its stages, and the checks of many parts.

The command is measured in a process of its own, with its start and imports in it: wall time, and
the processor's time with that of the slicers. The stages are those of one run in this process.
Controls: a process that imports MuJoCo and ends, and PrusaSlicer alone on each part as drawn.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.bench_commands import measure_floors
from experiments.figures.result_file import figure_name
from experiments.figures.save_options import parse_and_save
from morph.arrays import JSON
from morph.body.load import load
from morph.fabrication.divide import divide
from morph.files import write_whole
from morph.print.bed_pose import laid, mesh_of
from morph.print.clearance import clearances
from morph.print.gate import check_part
from morph.print.part import Part
from morph.print.prepare import prepare
from morph.print.printer import Profile, material, printer
from morph.print.slicer import find_slicer

EXAMPLE = """example:
  python -m experiments.bench_print
  python -m experiments.bench_print quadruped_printed --slice --json --out out/bench_print.json
"""

PROFILE = ("mk4", "pla")
"""Printer and plastic."""

CALL = "from morph.app.cli.main import entry; entry()"
"""The command, as it is installed."""


@dataclass(frozen=True, kw_only=True)
class Timed:
    """How long one thing took."""

    what: str
    """What was done."""
    wall: float
    """Seconds on the clock."""
    processor: float
    """Seconds of one processor, with children."""
    limit: float | None = None
    """Seconds on the clock that it may take; None if nothing was promised."""


def timed(what: str, call: Callable[[], object], limit: float | None = None) -> Timed:
    """Return how long a call takes."""
    began, used = time.perf_counter(), _used()
    call()
    return Timed(what=what, wall=time.perf_counter() - began, processor=_used() - used, limit=limit)


def command(body: str, slicer: str, limit: float | None) -> Timed:
    """Return how long the command takes for a body."""
    words = ["print", body, "--printer", PROFILE[0], "--material", PROFILE[1], "--quiet"]

    def call() -> None:
        with tempfile.TemporaryDirectory() as folder:
            given = [*words, "--slicer", slicer, "--out", str(Path(folder) / "package")]
            ended = subprocess.run([sys.executable, "-c", CALL, *given], capture_output=True)
        if ended.returncode not in (0, 3):
            sys.exit(ended.stderr.decode())

    how = "without a slicer" if slicer == "none" else "with the slicer"
    return timed(f"morph print {body}, {how}", call, limit)


def stages(body: str) -> list[Timed]:
    """Return how long each stage takes for a body, without a slicer."""
    profile = Profile(printer=printer(PROFILE[0]), material=material(PROFILE[1]))
    robot = load(body)
    marks: list[tuple[str, float, float]] = []

    def tell(said: str) -> None:
        stage = "joints" if said.startswith("turning joints") else said.split()[0]
        marks.append((stage, time.perf_counter(), _used()))

    tell("dividing")
    found = divide(robot, profile)
    prepare(found.parts, found.hinges, profile, slicer=None, tell=tell)
    tell("end")
    sums: dict[str, list[float]] = {}
    for (what, wall, used), (_, after, then) in pairwise(marks):
        both = sums.setdefault(what, [0.0, 0.0])
        both[0] += after - wall
        both[1] += then - used
    return [Timed(what=f"  {what}", wall=both[0], processor=both[1]) for what, both in sums.items()]


def checks(bodies: Sequence[str], count: int) -> Timed:
    """Return how long the checks of many parts take: each part of the bodies, again and again."""
    profile = Profile(printer=printer(PROFILE[0]), material=material(PROFILE[1]))
    found = [divide(load(body), profile) for body in bodies]
    parts = [part for division in found for part in division.parts if _printed(part)]
    many = [parts[at % len(parts)] for at in range(count)]

    def call() -> None:
        for part in many:
            check_part(part, profile)
        for division in found:
            clearances(division.parts, division.hinges, profile)

    joints = sum(len(division.hinges) for division in found)
    return timed(f"checks of {count} parts and {joints} joints", call, 20.0)


def slicer_alone(body: str) -> Timed:
    """Return how long PrusaSlicer takes for every part of a body, each once, as it is drawn."""
    profile = Profile(printer=printer(PROFILE[0]), material=material(PROFILE[1]))
    slicer = find_slicer()
    if slicer is None:
        raise RuntimeError("PrusaSlicer is gone")
    parts = [part for part in divide(load(body), profile).parts if _printed(part)]
    laid_out = [mesh.moved(laid(mesh, np.eye(3), profile)) for mesh in map(mesh_of, parts)]

    def call() -> None:
        for part, mesh in zip(parts, laid_out, strict=True):
            slicer.code({part.name: mesh}, profile)

    return timed(f"PrusaSlicer alone, {len(parts)} parts of {body} as drawn", call)


def controls_of(bodies: Sequence[str], *, sliced: bool) -> dict[str, JSON]:
    """Return what takes at least as long as must be: a start of Python, and the slicer alone."""
    _, floors = measure_floors(2)
    controls = {
        name: {"wall_s": each["seconds"], "processor_s": each["processor_s"]}
        for name, each in floors.items()
    }
    for body in bodies if sliced else ():
        alone = slicer_alone(body)
        controls[f"slicer alone {body}"] = {
            "wall_s": alone.wall,
            "processor_s": alone.processor,
        }
    return controls


def _printed(part: Part) -> bool:
    return part.kind == "printed" and part.mesh is not None


def _used() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the bench and return its exit status: 1 if something took longer than it may."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bench_print",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("bodies", nargs="*", default=["so101"], help="bodies; by default so101")
    parser.add_argument("--parts", type=int, default=50, help="how many parts are looked at")
    parser.add_argument("--slice", action="store_true", help="run the command with the slicer, too")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    parser.add_argument("--out", type=Path, help="write the figures to this file as JSON")
    asked, save = parse_and_save(parser, arguments, module="experiments.bench_print")
    if asked.slice and find_slicer() is None:
        parser.error("there is no prusa-slicer here; install it, or leave out --slice")
    rows = []
    for body in asked.bodies:
        rows += [command(body, "none", 60.0), *stages(body)]
        if asked.slice:
            rows.append(command(body, "needed", 360.0))
    rows.append(checks(asked.bodies, asked.parts))
    if save:
        figures = {f"{figure_name(row.what)}_processor_s": row.processor for row in rows}
        figures |= {f"{figure_name(row.what)}_wall_s": row.wall for row in rows}
        controls = controls_of(asked.bodies, sliced=asked.slice)
        save(figures=figures, controls=controls, rows=[asdict(row) for row in rows])
    said = json.dumps([asdict(each) for each in rows], indent=1)
    if asked.out is not None:
        write_whole(asked.out, said + "\n")
    if asked.json:
        sys.stdout.write(said + "\n")
    else:
        _show(rows)
    return int(any(each.limit is not None and each.wall > each.limit for each in rows))


def _show(rows: Sequence[Timed]) -> None:
    table = Table("what")
    for title in ("s on the clock", "s of a processor", "allowed"):
        table.add_column(title, justify="right")
    for each in rows:
        allowed = "" if each.limit is None else f"{each.limit:.0f}"
        table.add_row(each.what, f"{each.wall:.1f}", f"{each.processor:.1f}", allowed)
    Console(width=100).print(table)


if __name__ == "__main__":
    sys.exit(main())
