"""The incumbent, mujoco.sysid, beside morph.diagnose on the same recordings of one rig.

`morph.diagnose` runs twice: without a budget, and with the seconds that sysid takes as its budget.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from experiments.dfki_published import PUBLISHED, with_friction
from experiments.figures.save_options import parse_and_save
from experiments.incumbent import ITERATIONS, by_sysid, figures
from experiments.needs import need_recordings
from experiments.openloop import Model, bound, corrected, errors, in_row, laid, named, span
from morph.arrays import JSON
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.errors import MorphError
from morph.inference.diagnose import diagnose
from morph.model.split import between
from morph.record.recording import Recording

EXAMPLE = """example:
  python -m experiments.bench_diagnose
  python -m experiments.bench_diagnose --quick --json

Both get the same description, training runs, held-out runs, starts, commands, readings
and simulation step, and both are scored by the same function on runs that neither saw.
"""
FOLDER, BINDING, ROBOT = "dfki_double_pendulum", "dfki_c0", "double_pendulum"
DESIGN = "C.0"
TRAIN = ("run_00", "run_01", "run_02", "run_04")
HELD_OUT = ("run_03", "run_05", "run_06")
HORIZONS: tuple[float | None, ...] = (None, 1.0)
BUDGETED = "budgeted"
QUICK_SECONDS = 4.0
"""Of one training run: enough to see that both work, too little to compare them."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What one tool made of the training runs."""

    seconds: float
    """How long it took, from readings in memory to a model."""
    model: Model
    """What it says the rig is."""
    pointed_at: str
    """What it says was left out of the description, in words."""


def by_morph(
    robot: Robot,
    train: Sequence[Recording],
    aside: Sequence[Recording],
    horizon: float | None,
    budget: float | None = None,
) -> Entry:
    """Return what `morph.diagnose` finds, with default settings but for a budget in seconds."""
    began = time.monotonic()
    found = diagnose(robot, train, held_out=aside, horizon=horizon, budget=budget)
    seconds = time.monotonic() - began
    effects = [finding.effect for finding in found.findings]
    return Entry(
        seconds=seconds,
        model=corrected(found),
        pointed_at=f"{found.verdict}: {named(effects)}" if effects else found.verdict,
    )


def by_incumbent(
    robot: Robot, train: Sequence[Recording], *, piece: float | None, iterations: int
) -> Entry:
    """Return what `mujoco.sysid` fits; it ranks and names nothing."""
    began = time.monotonic()
    model, values = by_sysid(robot, laid(train, robot), piece=piece, iterations=iterations)
    seconds = time.monotonic() - began
    moved = {figure.name: (figure.nominal, values[figure.name]) for figure in figures(robot)}
    told = ", ".join(f"{name} {was:.3g} -> {now:.3g}" for name, (was, now) in moved.items())
    return Entry(seconds=seconds, model=model, pointed_at=f"nothing; {len(moved)} figures: {told}")


def ratio(ours: Mapping[str, float], theirs: Mapping[str, float]) -> float:
    """Return the geometric mean over joints of our error over theirs."""
    logs = [math.log(ours[joint] / theirs[joint]) for joint in ours]
    return math.exp(sum(logs) / len(logs))


def compared(
    robot: Robot, entries: Mapping[str, Entry], aside: Sequence[Recording], ours: str, theirs: str
) -> JSON:
    """Return times, held-out errors of each entry and of two baselines, and ratios."""
    runs = laid(aside, robot)
    rig = PUBLISHED[DESIGN]
    baselines = {
        "nominal": Model(robot=robot),
        "published friction": with_friction(robot, rig.level, rig.viscous),
    }
    rows = []
    for horizon in HORIZONS:
        rmse = {name: errors(model, runs, horizon) for name, model in baselines.items()}
        rmse |= {name: errors(entry.model, runs, horizon) for name, entry in entries.items()}
        rows.append(
            {
                "horizon_s": horizon,
                "rmse": rmse,
                "error_ratio": ratio(rmse[ours], rmse[theirs]),
                "error_ratio_budgeted": ratio(rmse[BUDGETED], rmse[theirs]),
            }
        )
    return {
        "held_out": [recording.name for recording in aside],
        "seconds": {name: entry.seconds for name, entry in entries.items()},
        "time_ratio": entries[ours].seconds / entries[theirs].seconds,
        "pointed_at": {name: entry.pointed_at for name, entry in entries.items()},
        "scores": rows,
    }


def report(result: JSON) -> None:
    """Print the comparison."""
    for name, seconds in result["seconds"].items():
        print(f"{name}: {seconds:.1f} s; pointed at {result['pointed_at'][name]}")
    print(f"time, morph / sysid: {result['time_ratio']:.3f}")
    for row in result["scores"]:
        joints = next(iter(row["rmse"].values()))
        print(f"RMSE, rad, over {', '.join(result['held_out'])}; {span(row['horizon_s'])}:")
        print(f"  {'':34} " + "  ".join(f"{joint:>8}" for joint in joints))
        for name, by_joint in row["rmse"].items():
            print(in_row(name, by_joint))
        print(
            f"  error, morph / sysid: {row['error_ratio']:.3f}; in the same seconds: "
            f"{row['error_ratio_budgeted']:.3f}"
        )


def headline(result: JSON) -> JSON:
    """Return what a result file holds: seconds, errors over whole runs, rad, and their ratios."""
    whole, *short = result["scores"]
    figures = {f"{name}_seconds": seconds for name, seconds in result["seconds"].items()}
    for name in result["seconds"]:
        figures |= {f"{name}_{joint}": error for joint, error in whole["rmse"][name].items()}
    figures |= {"time_ratio": result["time_ratio"], "error_ratio": whole["error_ratio"]}
    figures["error_ratio_short"] = short[0]["error_ratio"]
    figures["error_ratio_budgeted"] = whole["error_ratio_budgeted"]
    controls = {
        "as described": whole["rmse"]["nominal"],
        "published friction": whole["rmse"]["published friction"],
        "sysid": whole["rmse"]["sysid"],
    }
    return {"figures": figures, "controls": controls, "rows": result["scores"]}


def run(*, quick: bool, piece: float | None, iterations: int) -> JSON:
    """Return the comparison on the rig's runs.

    Raises:
        MorphError: The recordings are not there or cannot be used.
    """
    root = need_recordings(FOLDER)
    robot = load_robot(ROBOT)
    train, aside = (bound(BINDING, FOLDER, robot, names, root=root) for names in (TRAIN, HELD_OUT))
    if quick:
        train = [between(train[0], train[0].start, train[0].start + QUICK_SECONDS)]
        iterations = min(iterations, 10)
    sys.stderr.write("morph.diagnose ...\n")
    entries = {"morph": by_morph(robot, train, aside, None)}
    sys.stderr.write("mujoco.sysid ...\n")
    entries["sysid"] = by_incumbent(robot, train, piece=piece, iterations=iterations)
    sys.stderr.write("morph.diagnose with the seconds of sysid as its budget ...\n")
    budget = entries["sysid"].seconds
    entries[BUDGETED] = by_morph(robot, train, aside, None, budget)
    result = compared(robot, entries, aside, "morph", "sysid")
    settings = {"quick": quick, "sysid_rollout_s": piece, "sysid_iterations": iterations}
    return {"train": [recording.name for recording in train], "settings": settings, **result}


def main(arguments: list[str] | None = None) -> int:
    """Run the benchmark and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.bench_diagnose",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="4 s of one run: does it work at all")
    parser.add_argument(
        "--piece",
        type=float,
        metavar="S",
        help="seconds of the rollouts that sysid fits (default: whole runs, as its examples do)",
    )
    parser.add_argument(
        "--iterations",
        type=int,
        default=ITERATIONS,
        help="the most that sysid may take (default %(default)s, its own)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of words")
    asked, save = parse_and_save(parser, arguments, module="experiments.bench_diagnose")
    try:
        result = run(quick=asked.quick, piece=asked.piece, iterations=asked.iterations)
        if save:
            save(**headline(result))
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if asked.json:
        print(json.dumps(result, indent=1))
    else:
        report(result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
