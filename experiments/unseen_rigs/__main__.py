"""Seven robots that nobody here built, by another dynamics library, with something left out.

A trotting quadruped with a worn foot, a biped with a load, a swimmer with growth on a paddle, a leg
of four bars with play, an arm with a tool of which torques are logged, a vehicle with a weak
thruster, a hexapod that is pushed: is each diagnosed, named, and better predicted? Legged robots
are diagnosed once more from an inertial sensor in the place of a camera. Controls: the same robots
with nothing left out, of which nothing may be found, and the error of the description.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.engine_options import add_engine_options, rows_of, seeds_of
from experiments.figures.save_options import parse_and_save
from experiments.unseen_rigs.dynamics import RATE, Simulated
from experiments.unseen_rigs.plant import Moved
from experiments.unseen_rigs.rig import Rig
from experiments.unseen_rigs.rigs import RIGS
from morph.arrays import JSON, Array
from morph.body.load import load
from morph.errors import MorphError
from morph.inference.diagnose import diagnose
from morph.record.recording import Channel, Recording
from morph.study.cell import cells_of

EXAMPLE = """example:
  python -m experiments.unseen_rigs --only arm vehicle --seeds 1:2"""

RUNS, SECONDS, NOISE = 4, 6.0, 5e-4
"""Runs of a rig and how long each is, s; noise of positions, rad and m, and of quaternions."""
EFFORT_NOISE = 0.002
"""Of torques, as a share of the greatest at the joint."""
GYRO, ACCELEROMETER = 0.01, 0.1
"""Noise of an inertial sensor at the middle of the trunk, rad/s and m/s2."""
BUDGET = 600.0
"""Seconds that a diagnosis is given."""
SURE = 0.5
"""Probability from which something is claimed."""


def recorded(
    rig: Rig, moved: Moved, plant: Simulated, name: str, rng: np.random.Generator, *, inertial: bool
) -> Recording:
    """Return a motion as it is logged."""

    def noisy(values: Array, size: float, *, early: float = 0.0) -> Channel:
        read = values + rng.normal(0.0, size, values.shape)
        return Channel(time=moved.time[1:] - early, value=read[1:])

    def of_base(channel: str, values: Array, size: float, axes: str = "xyz") -> dict[str, Channel]:
        return {f"{channel}.{axis}": noisy(values[:, at], size) for at, axis in enumerate(axes)}

    channels = {
        f"{joint}.position": noisy(moved.position[:, at], NOISE)
        for joint, (at, _) in plant.hinges.items()
    }
    if rig.by_effort:
        channels |= {
            f"{joint}.effort": noisy(values, EFFORT_NOISE * float(np.abs(values).max()))
            for joint, values in moved.effort.items()
        }
    else:
        channels |= {
            f"{motor}.command": Channel(time=moved.told_at, value=values, hold=True)
            for motor, values in moved.told.items()
        }
    if inertial:
        channels |= of_base("imu.gyro", moved.spin, GYRO)
        for at, axis in enumerate("xyz"):
            # It is the mean of the time since the reading before.
            channels[f"imu.accelerometer.{axis}"] = noisy(
                moved.pull[:, at], ACCELEROMETER, early=0.5 / RATE
            )
    elif rig.base:
        channels |= of_base(f"{rig.base}.position", moved.position[:, :3], NOISE)
        channels |= of_base(f"{rig.base}.orientation", moved.position[:, 3:7], NOISE, "xyzw")
    return Recording(name=name, channels=channels)


def runs_of(rig: Rig, seed: int, name: str, *, lacking: bool, inertial: bool) -> list[Recording]:
    """Return the runs of a rig."""
    rng = np.random.default_rng([91, seed, zlib.crc32(name.encode()), int(lacking)])
    runs = []
    for at in range(RUNS):
        left_out = lacking and (not rig.once or at == 1)
        plant = Simulated(rig.lacking if left_out else rig.described)
        phases = rng.uniform(0.0, 2.0 * np.pi, 12)
        moved = plant.moved(_controller(rig, phases), _start(rig, plant), SECONDS)
        runs.append(recorded(rig, moved, plant, f"take_{at}", rng, inertial=inertial))
    return runs


def _controller(rig: Rig, phases: Array) -> Any:
    """Return what tells the motors to lead the joints."""
    stiff, damp = rig.gains

    def act(t: float, place: Any, speed: Any) -> dict[str, float]:
        wanted = rig.led(phases, t)
        return {
            name: stiff * (to - place[name]) - damp * speed[name] if name in place else to
            for name, to in wanted.items()
        }

    return act


def _start(rig: Rig, plant: Simulated) -> Array:
    start = plant.pin.neutral(plant.model)
    if rig.base:
        start[2] = rig.height
    for joint, value in rig.start.items():
        start[plant.hinges[joint][0]] = value
    return np.asarray(start)


def case(rig: str, seed: int, *, lacking: bool, inertial: bool) -> JSON:
    """Return what is found of one rig."""
    with tempfile.TemporaryDirectory() as folder:
        built = RIGS[rig](Path(folder))
        robot = load(built.described.description)
        runs = runs_of(built, seed, rig, lacking=lacking, inertial=inertial)
        row: JSON = {"rig": rig, "seed": seed, "lacking": lacking, "inertial": inertial}
        began = time.process_time()
        try:
            found = diagnose(robot, runs[:-1], held_out=runs[-1:], budget=BUDGET)
        except MorphError as error:
            return {**row, "refused": error.what, "names": built.names}
    errors = {
        model: float(np.mean(list(by_channel.values())))
        for model, by_channel in found.held_out_rmse.items()
    }
    return {
        **row,
        "names": built.names,
        "found": [each.effect.label for each in found.findings],
        "probability": [each.probability for each in found.findings],
        "rivals": [f"{r.effect}@{r.where}" for each in found.findings for r in each.rivals],
        "verdict": found.verdict,
        "changes": len(found.changes),
        "errors": errors,
        "cpu_seconds": time.process_time() - began,
    }


def figures_of(rows: Sequence[JSON]) -> JSON:
    """Return shares of rigs that are diagnosed, named first, among the named, and accused."""
    told = [row for row in rows if row["lacking"]]
    clean = [row for row in rows if not row["lacking"] and "refused" not in row]
    named = [row for row in told if "refused" not in row]
    accused = [
        any(each >= SURE for each in row["probability"]) or row["changes"] > 0 for row in clean
    ]
    return {
        "rigs": len(told),
        "diagnosed": sum("refused" not in row for row in rows) / max(1, len(rows)),
        "first": sum(row["found"][:1] != [] and row["found"][0] in row["names"] for row in named),
        "named": sum(bool(set(row["found"] + row["rivals"]) & set(row["names"])) for row in named),
        "clean": len(clean),
        "accused": sum(accused),
        "better": sum(row["errors"]["corrected"] < row["errors"]["described"] for row in named),
    }


def main(argv: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.unseen_rigs",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", nargs="+", choices=list(RIGS), default=list(RIGS))
    parser.add_argument("--seeds", default="1:2", help="random seeds: A:B, or how many from 0")
    add_engine_options(parser, out="out/unseen_rigs")
    asked, save = parse_and_save(parser, argv, module="experiments.unseen_rigs")
    seeds = seeds_of(asked.seeds)
    cases = [
        {"rig": rig, "seed": seed, "lacking": lacking, "inertial": inertial}
        for seed in seeds
        for rig in asked.only
        for inertial in ((False, True) if rig in ("quadruped", "hexapod") else (False,))
        for lacking in (False, True)
    ]
    rows = rows_of(cells_of(case, cases), asked, name="unseen_rigs")
    figures = figures_of([row for row in rows if "why" not in row])
    for row in rows:
        print(json.dumps(row))
    print(json.dumps(figures, indent=1))
    if save:
        nothing = {"first": 0, "named": 0, "accused": 0}
        save(figures=figures, controls={"nothing named": nothing}, rows=rows, seeds=seeds)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
