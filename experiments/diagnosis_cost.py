"""What a diagnosis costs: against joints, samples and laws, in a process of its own each.

Arms of any number of joints, drawn at random, are led along sines with dry friction at one joint
that their descriptions lack. Seconds are of all processors; exponents are slopes of their
logarithm, over the larger half of the sizes. The control is what reading the files alone takes.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from experiments.bench_commands import measured
from experiments.figures.save_options import parse_and_save
from morph.arrays import JSON
from morph.errors import MorphError
from morph.files import write_whole

EXAMPLE = """examples:
  python -m experiments.diagnosis_cost --only joints --joints 2 4 --save-as out/cost.json
  python -m experiments.diagnosis_cost --plot out/cost.html"""

JOINTS = (2, 3, 4, 6, 8)
"""Of arms that are diagnosed to the end."""
MANY = 25
"""Of the arm that is diagnosed within `BUDGET`, s."""
BUDGET = 60.0
SAMPLES = (10_000, 30_000, 100_000, 300_000, 1_000_000, 10_000_000)
"""Readings and commands of all channels together, of an arm of two joints."""
LAWS = (5, 10, 20, 40)
"""How many kinds of law are looked for."""
SECONDS, RUNS, RATE, NOISE = 60.0, 3, 100.0, 5e-4
"""Of data in all, in how many runs, readings a second and their noise, rad."""
FRICTION = 0.2
"""Of the effort of the joint that lacks it, RMS."""
CALL = "import sys; from experiments.diagnosis_cost import one; one(*sys.argv[1:])"
"""A diagnosis in a process of its own."""
PARTS = ("joints", "many", "samples", "laws")


def arm(joints: int, seed: int) -> str:
    """Return an arm of links of 0.2 m whose axes are drawn, as MJCF."""
    rng, body, actuators = np.random.default_rng([77, seed, joints]), "", ""
    for at in reversed(range(joints)):
        axis = " ".join(f"{each:.3f}" for each in rng.normal(size=3))
        mass = rng.uniform(0.2, 0.5) * (1.0 + joints - at)
        body = (
            f'<body name="link{at}" pos="{0.2 if at else 0} 0 0"><joint name="j{at}" axis="{axis}"'
            f' damping="{0.05 * mass:.3f}" armature="{0.02 * mass:.3f}"/><geom type="capsule" '
            f'fromto="0 0 0 0.2 0 0" size="0.03" mass="{mass:.3f}" contype="0" conaffinity="0"/>'
            f"{body}</body>"
        )
        actuators = f'<motor name="m{at}" joint="j{at}"/>{actuators}'
    world = f"<worldbody>{body}</worldbody><actuator>{actuators}</actuator>"
    return f'<mujoco model="arm">{world}</mujoco>'


def written(folder: Path, joints: int, seed: int, *, samples: int | None = None) -> list[Path]:
    """Write an arm and its runs, and return their files."""
    from experiments import bodies_driven
    from morph.body.load import load
    from morph.physics.joint.coulomb_friction import CoulombFriction
    from morph.record.write import write

    robot_file = folder / "arm.xml"
    write_whole(robot_file, arm(joints, seed))
    robot, rng, files = load(robot_file), np.random.default_rng([78, seed, joints]), [robot_file]
    # Commands come five times as often as readings.
    each_second = joints * (RATE + 1.0 / bodies_driven.PERIOD)
    seconds = SECONDS if samples is None else samples / each_second
    with mock.patch.object(bodies_driven, "SECONDS", seconds / RUNS):
        plain = bodies_driven.moved_along_sines(robot, (), np.random.default_rng(seed))
        middle = f"j{joints // 2}"
        effort = float(np.sqrt(np.mean(plain.command[f"m{joints // 2}"] ** 2)))
        law = CoulombFriction(joint=middle, c=FRICTION * effort)
        for at in range(RUNS):
            moved = bodies_driven.moved_along_sines(robot, (law,), rng)
            run = bodies_driven.read(robot, (law,), moved, rng, f"run{at}")
            # The file keeps each clock: commands on that of the readings would come late.
            files.append(folder / f"run{at}.npz")
            write(run, files[-1])
    return files


def one(out: str, budget: str, laws: str, robot: str, *files: str) -> None:
    """Diagnose an arm and write what was found and how long that took.

    Args:
        out: File that is written.
        budget: Seconds, or nothing for no budget.
        laws: How many kinds of law are looked for, or nothing for all.
        robot: Its description.
        files: Its runs.
    """
    import morph
    from morph.inference import dictionary
    from morph.inference.diagnose import diagnose
    from morph.physics import EFFECTS

    began = time.process_time()
    body = morph.load(robot)
    runs = [run for file in files for run in morph.load_recordings(file, robot=body)]
    read = time.process_time() - began
    # Dry friction is always among them.
    kinds = sorted(EFFECTS, key=lambda kind: kind.name != "coulomb_friction")
    with mock.patch.object(dictionary, "EFFECTS", kinds[: int(laws or len(kinds))]):
        found = diagnose(body, runs, budget=float(budget) if budget else None)
    result = {
        "read_s": read,
        "found": [each.effect.label for each in found.findings],
        "verdict": found.verdict,
        "stopped_short": found.stopped_short,
    }
    write_whole(Path(out), json.dumps(result))


def cell(part: str, size: int, folder: Path, *, seed: int) -> JSON:
    """Return what the diagnosis of one arm costs."""
    joints = size if part in {"joints", "many"} else 2
    files = written(folder, joints, seed, samples=size if part == "samples" else None)
    budget = f"{BUDGET:g}" if part == "many" else ""
    laws = str(size) if part == "laws" else ""
    out = folder / "found.json"
    used = measured(CALL, str(out), budget, laws, *map(str, files))
    found = json.loads(out.read_text())
    hidden = f"coulomb_friction@j{joints // 2}"
    return {"part": part, "size": size, **used, **found, "right": found["found"][:1] == [hidden]}


def exponent(rows: Sequence[JSON]) -> float:
    """Return the slope of the logarithm of seconds over that of sizes, over their larger half."""
    rows = sorted(rows, key=lambda row: row["size"])[(len(rows) - 1) // 2 :]
    sizes, seconds = (np.log([row[key] for row in rows]) for key in ("size", "processor_s"))
    return float(np.polyfit(sizes, seconds, 1)[0])


def plotted(rows: Sequence[JSON], path: Path) -> None:
    """Write seconds against sizes, as a page."""
    from plotly.subplots import make_subplots

    parts = [part for part in ("joints", "samples", "laws") if any(r["part"] == part for r in rows)]
    figure = make_subplots(cols=len(parts), subplot_titles=parts)
    for at, part in enumerate(parts, 1):
        mine = [row for row in rows if row["part"] == part]
        sizes = [row["size"] for row in mine]
        figure.add_scatter(
            x=sizes, y=[row["processor_s"] for row in mine], mode="lines+markers", row=1, col=at
        )
        figure.update_xaxes(type="log", title=part, row=1, col=at)
        figure.update_yaxes(type="log", title="CPU-seconds", row=1, col=at)
    write_whole(path, figure.to_html(include_plotlyjs=True))


def main(argv: list[str] | None = None) -> int:
    """Run the benchmark and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.diagnosis_cost",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", choices=PARTS, nargs="+", default=list(PARTS))
    parser.add_argument("--joints", type=int, nargs="+", default=list(JOINTS))
    parser.add_argument("--samples", type=int, nargs="+", default=list(SAMPLES))
    parser.add_argument("--laws", type=int, nargs="+", default=list(LAWS))
    parser.add_argument("--seed", type=int, default=1, help="random seed of arms and motions")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="write seconds against sizes")
    asked, save = parse_and_save(parser, argv, module="experiments.diagnosis_cost")
    sizes = {"joints": asked.joints, "many": [MANY], "samples": asked.samples, "laws": asked.laws}
    rows: list[JSON] = []
    try:
        for part in asked.only:
            for size in sizes[part]:
                with tempfile.TemporaryDirectory() as folder:
                    rows.append(cell(part, size, Path(folder), seed=asked.seed))
                print(json.dumps(rows[-1]), flush=True)
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if asked.plot:
        plotted(rows, asked.plot)
    if save:
        reading = {f"{row['part']}_{row['size']}": row["read_s"] for row in rows}
        save(
            figures=figures_of(rows),
            controls={"reading the files alone": reading},
            rows=rows,
            seeds=[asked.seed],
        )
    return 0


def figures_of(rows: Sequence[JSON]) -> dict[str, Any]:
    """Return exponents, and what the largest of each part takes."""
    figures: dict[str, Any] = {"right": sum(row["right"] for row in rows), "cells": len(rows)}
    for part in PARTS:
        mine = [row for row in rows if row["part"] == part]
        if mine:
            most = max(mine, key=lambda row: row["size"])
            figures |= {
                f"{part}_most": most["size"],
                f"{part}_seconds": most["seconds"],
                f"{part}_processor_s": most["processor_s"],
                f"{part}_memory_mb": most["memory_mb"],
            }
            if len(mine) > 2:
                figures[f"{part}_exponent"] = exponent(mine)
    return figures


if __name__ == "__main__":
    raise SystemExit(main())
