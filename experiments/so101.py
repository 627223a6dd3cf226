"""An SO-101 arm as six position servos: what a linear servo leaves out.

Fits two motions of three, opens every third one afterwards, and compares the
description's linear servos, refitted, with the corrected ones, motion by motion.
The servos' gains are not documented, so gains and armatures may be off by a factor of
four; the links' masses are those of the public description, and trusted.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

from experiments.data import DataError
from experiments.figures.save_options import parse_and_save
from experiments.needs import need_recordings
from experiments.openloop import BINDINGS, named
from morph.arrays import JSON
from morph.body.load import load as load_robot
from morph.errors import MorphError
from morph.inference.diagnose import diagnose
from morph.model.diagnosis import Diagnosis, Trace
from morph.record.load import load_recordings
from morph.record.recording import Recording

EXAMPLE = """example:
  python -m experiments.so101
  python -m experiments.so101 --joints Rotation Wrist_Pitch --json
  python -m experiments.so101 --beside 60
"""
VARY = {"mass": 0.0, "com": 0.0, "inertia": 0.0, "gain": 3.0, "joint": 3.0}
"""Gains and armatures within a factor of four; masses as described."""
SLOW = 0.25
"""rad/s: root mean square speed of a joint's command below which a motion is slow."""


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.so101",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--root", type=Path, help="folder of so101_sage (default: where data is)")
    parser.add_argument("--joints", nargs="+", default=["Rotation", "Wrist_Pitch"], help="to show")
    parser.add_argument("--every", type=int, default=3, help="hold out every n-th motion")
    parser.add_argument("--only", nargs="+", help="names of motions to use (default: all)")
    parser.add_argument(
        "--budget", type=float, help="seconds after which it answers (default: none)"
    )
    parser.add_argument(
        "--beside", type=float, metavar="S", help="diagnose again with this budget, as a control"
    )
    parser.add_argument("--out", type=Path, help="folder for the diagnosis and its report")
    parser.add_argument("--json", action="store_true", help="print rows as JSON")
    asked, save = parse_and_save(parser, arguments, module="experiments.so101")
    try:
        found, moved = studied(asked.root, asked.every, asked.only, asked.budget)
        early = None
        if asked.beside is not None:
            early, _ = studied(asked.root, asked.every, asked.only, asked.beside)
        if asked.out:
            from morph.app.report.files import write_diagnosis

            write_diagnosis(found, asked.out)
    except (MorphError, DataError) as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    rows = compared(found, moved)
    result = headline(found, rows)
    if early is not None:
        figures = headline(early, compared(early, moved))["figures"]
        result["controls"][f"budget of {asked.beside:g} s"] = figures
    if save:
        save(**result)
    if asked.json:
        print(json.dumps({"diagnosis": found.as_json(), "rows": rows}, indent=1))
    else:
        report(found, rows, asked.joints)
        if early is not None:
            print(f"with a budget of {asked.beside:g} s:")
            report(early, compared(early, moved), [])
    return 0


def studied(
    root: Path | None, every: int, only: list[str] | None, budget: float | None = None
) -> tuple[Diagnosis, dict[str, Recording]]:
    """Return the diagnosis, and the held-out motions by name."""
    robot = load_robot("so101")
    folder = (root or need_recordings("so101_sage")) / "so101_sage"
    motions = load_recordings(BINDINGS / "so101.toml", robot=robot, root=folder)
    motions = tuple(m for m in motions if only is None or m.name in only)
    aside = motions[1::every]
    kept_shut = {motion.name for motion in aside}
    train = [motion for motion in motions if motion.name not in kept_shut]
    began = time.monotonic()
    found = diagnose(
        robot,
        train,
        held_out=aside,
        vary=VARY,
        budget=budget,
        progress=lambda what, share: print(
            f"[{time.monotonic() - began:5.0f} s, {100 * share:3.0f} %] {what}", file=sys.stderr
        ),
    )
    return found, {motion.name: motion for motion in aside}


def compared(found: Diagnosis, motions: dict[str, Recording]) -> list[JSON]:
    """Return a row for each held-out motion and joint: error before and after, and speed."""
    rows = []
    for trace in found.traces:
        joint = trace.channel.removesuffix(".position")
        command = motions[trace.episode].channel(f"{joint}.command")
        speed = np.gradient(command.value, command.time)
        rows.append(
            {
                "motion": trace.episode,
                "joint": joint,
                "command_speed": float(np.sqrt(np.mean(speed**2))),
                "linear": _rmse(trace, "refitted"),
                "corrected": _rmse(trace, "corrected"),
                "nominal": _rmse(trace, "nominal"),
                "noise": found.held_out_rmse["noise_floor"][trace.channel],
            }
        )
    return rows


def _rmse(trace: Trace, model: str) -> float:
    return float(np.sqrt(np.nanmean((trace.models[model] - trace.measured) ** 2)))


def headline(found: Diagnosis, rows: list[JSON]) -> JSON:
    """Return what a result file holds: errors on slow motions, rad, joint by joint."""
    figures: JSON = {"motions": len({row["motion"] for row in rows}), "verdict": found.verdict}
    figures["seconds"] = found.seconds
    figures["found"] = ", ".join(finding.effect.label for finding in found.findings)
    figures["worse"] = sum(row["corrected"] > row["linear"] + 0.1 * row["noise"] for row in rows)
    controls: JSON = {"linear servo, refitted": {}, "as described": {}}
    for joint in dict.fromkeys(row["joint"] for row in rows):
        slow = [r for r in rows if r["joint"] == joint and 0.0 < r["command_speed"] < SLOW]
        if slow:
            figures[f"{joint.lower()}_corrected"] = _mean(slow, "corrected")
            figures[f"{joint.lower()}_linear"] = _mean(slow, "linear")
            controls["linear servo, refitted"][joint] = _mean(slow, "linear")
            controls["as described"][joint] = _mean(slow, "nominal")
    return {"figures": figures, "controls": controls, "rows": rows}


def report(found: Diagnosis, rows: list[JSON], joints: list[str]) -> None:
    """Print the findings, the table, and whether any motion got worse."""
    print(f"verdict: {found.verdict}, {found.seconds:.0f} s")
    print(f"findings: {named(finding.effect for finding in found.findings) or 'none'}")
    print(f"{'motion':28} {'joint':12} {'speed':>6} {'nominal':>8} {'linear':>8} {'corrected':>9}")
    for row in rows:
        if row["joint"] in joints:
            print(
                f"{row['motion']:28} {row['joint']:12} {row['command_speed']:6.2f} "
                f"{row['nominal']:8.4f} {row['linear']:8.4f} {row['corrected']:9.4f}"
            )
    for joint in dict.fromkeys(row["joint"] for row in rows):
        mine = [row for row in rows if row["joint"] == joint]
        # A reading's own noise is no reason to call a motion worse.
        rising = [r["motion"] for r in mine if r["corrected"] > r["linear"] + 0.1 * r["noise"]]
        slow = [row for row in mine if 0.0 < row["command_speed"] < SLOW]
        moved = [row for row in mine if row["command_speed"] > 0.0]
        print(
            f"{joint}: slow motions {_fall(slow)}, all that move it {_fall(moved)} rad; "
            f"worse on {len(rising)} of {len(mine)} {', '.join(rising)}"
        )


def _fall(rows: list[JSON]) -> str:
    return f"{_mean(rows, 'linear'):.4f} -> {_mean(rows, 'corrected'):.4f}"


def _mean(rows: list[JSON], model: str) -> float:
    return float(np.sqrt(np.mean([row[model] ** 2 for row in rows]))) if rows else float("nan")


if __name__ == "__main__":
    sys.exit(main())
