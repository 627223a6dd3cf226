"""Real tosses of a cube, diagnosed: is the floor's friction named, by a description without it?"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from experiments.cube import PUBLISHED
from experiments.cube_tosses import DESCRIPTION, FOLDER, RATE, on, tosses
from experiments.figures.save_options import parse_and_save
from experiments.needs import need_recordings
from experiments.openloop import from_mjcf
from morph.arrays import JSON, Array
from morph.body.robot import Robot
from morph.errors import MorphError
from morph.inference.diagnose import diagnose
from morph.inference.prepared import IMPACT
from morph.model.diagnosis import Diagnosis
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.score import rmse, rollouts
from morph.model.segments import scored_segments
from morph.physics.contact.contact_friction import ContactFriction
from morph.record.quantities import WXYZ, XYZ
from morph.record.recording import Channel, Recording
from morph.sim.rollout import rollout

EXAMPLE = """example:
  python -m experiments.cube_diagnosis
  python -m experiments.cube_diagnosis --first 0 --json
"""
ON_TABLE = DESCRIPTION.replace(
    "<worldbody>", '<worldbody><geom name="floor" type="plane" size="0 0 1"/>'
)
"""The cube on a table, both as MuJoCo takes shapes of which nothing is said."""
HORIZON = 0.5
"""Seconds of the held-out rollouts."""
NOISE = 2e-5
"""Standard deviation of the readings of the control, m; of the recorded positions it is as much."""
TOLD = "told the published friction"


def recorded(runs: Sequence[Array], first: int) -> list[Recording]:
    """Return tosses, (samples, 7 or more) each, as recordings of the cube's pose."""
    found = []
    for number, run in enumerate(runs):
        time = np.arange(len(run)) / RATE
        names = [f"cube.position.{axis}" for axis in XYZ]
        names += [f"cube.orientation.{axis}" for axis in WXYZ]
        channels = {
            name: Channel(time=time, value=run[:, at].copy()) for at, name in enumerate(names)
        }
        found.append(Recording(name=f"toss_{first + number}", channels=channels))
    return found


def described(robot: Robot, runs: Sequence[Array]) -> list[Array]:
    """Return tosses from the starts of some as the description says, with noise of readings."""
    rng, found = np.random.default_rng(0), []
    variant = on(robot, ())
    finer = round(1.0 / RATE / variant.model.opt.timestep)
    for run in runs:
        steps = finer * (len(run) - 1)
        none = np.zeros((1, steps, 0))
        start = run[None, 0]
        q, _ = rollout([variant], np.zeros(1, dtype=int), start[:, :7], start[:, 7:], none)
        found.append(q[0, ::finer] + NOISE * rng.normal(size=(len(run), 7)))
    return found


def studied(root: Path, *, first: int, fitted: int, judged: int) -> JSON:
    """Return what is found on real tosses, on tosses that are as described, and errors of both.

    Args:
        root: Folder of the recordings.
        first: The first toss that is fitted.
        fitted: How many are.
        judged: How many of the next are held out.
    """
    robot = from_mjcf(ON_TABLE)
    real = tosses(root, range(first, first + fitted + judged))
    runs = recorded(real, first)
    found = diagnose(robot, runs[:fitted], held_out=runs[fitted:], horizon=HORIZON)
    step = step_for(runs, robot, longest=IMPACT)
    aside = [episode(run, robot, step) for run in runs[fitted:]]
    segments = scored_segments(aside, HORIZON)
    law = ContactFriction(contact="any+floor", mu=PUBLISHED)
    told = Hypothesis(robot=robot, step=step, knobs=(), effects=(law,))
    error = rmse(segments, rollouts({TOLD: (told, told.start)}, segments)[TOLD])
    errors = {name: _distance(list(row.values())) for name, row in found.held_out_rmse.items()}
    clean = recorded(described(robot, real), first)
    control = diagnose(robot, clean[:fitted], held_out=clean[fitted:], horizon=HORIZON)
    return {
        "tosses": [first, first + fitted - 1, first + fitted + judged - 1],
        "found": _findings(found),
        "verdict": found.verdict,
        "in_noise": found.unexplained.in_noise,
        "seconds": found.seconds,
        "position_mm": {**errors, TOLD: _distance(error.tolist())},
        "as_described": {
            "found": _findings(control),
            "verdict": control.verdict,
            "in_noise": control.unexplained.in_noise,
        },
    }


def _distance(errors: Sequence[float]) -> float:
    """Return the RMS distance by the errors of three coordinates, the first, mm."""
    return float(1e3 * np.linalg.norm(errors[:3]))


def _findings(found: Diagnosis) -> list[JSON]:
    return [
        {
            "effect": each.effect.label,
            "probability": each.probability,
            **{name: estimate.value for name, estimate in each.parameters.items()},
        }
        for each in found.findings
    ]


def headline(result: JSON) -> JSON:
    """Return what a result file holds."""
    friction = [each for each in result["found"] if each["effect"].startswith("contact_friction@")]
    figures = {
        "friction": friction[0]["mu"] if friction else float("nan"),
        "published_friction": PUBLISHED,
        "probability": friction[0]["probability"] if friction else 0.0,
        "found": len(result["found"]),
        "found_as_described": len(result["as_described"]["found"]),
        "seconds": result["seconds"],
        **{f"{k.split(',')[0].replace(' ', '_')}_mm": v for k, v in result["position_mm"].items()},
    }
    rows = [{"model": name, "position_mm": v} for name, v in result["position_mm"].items()]
    controls = {"as described": {"found": len(result["as_described"]["found"])}}
    return {"figures": figures, "controls": controls, "rows": rows, "seeds": [result["tosses"][0]]}


def report(result: JSON) -> None:
    """Print the study."""
    first, fitted, last = result["tosses"]
    print(
        f"tosses {first} to {fitted} fitted, {fitted + 1} to {last} held out; "
        f"{result['verdict']}, {result['seconds']:.0f} s"
    )
    for each in result["found"]:
        rest = ", ".join(f"{k} {v:.4g}" for k, v in each.items() if k != "effect")
        print(f"  {each['effect']}: {rest} (published friction {PUBLISHED})")
    print(f"position over {HORIZON} s, held out, RMS:")
    for name, error in result["position_mm"].items():
        print(f"  {name:32}{error:8.1f} mm")
    said = result["as_described"]
    names = ", ".join(each["effect"] for each in said["found"]) or "nothing"
    print(f"tosses simulated as described: {names} found, {said['verdict']}")


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.cube_diagnosis",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--first", type=int, default=200, help="first toss (default: 200)")
    parser.add_argument("--fitted", type=int, default=60, help="how many are fitted (default: 60)")
    parser.add_argument(
        "--judged", type=int, default=30, help="how many are held out (default: 30)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    asked, save = parse_and_save(parser, arguments, module="experiments.cube_diagnosis")
    if asked.first < 0 or min(asked.fitted, asked.judged) < 4:
        parser.error("--first is 0 or more, --fitted and --judged are at least 4")
    try:
        root = need_recordings(FOLDER)
        result = studied(root, first=asked.first, fitted=asked.fitted, judged=asked.judged)
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
