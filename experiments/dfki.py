"""The double pendulum of DFKI: what was left out of its description, on two designs."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from experiments.data import DataError, data_root
from experiments.openloop import Model, bound, corrected, errors, from_mjcf, in_row, laid, span
from morph.arrays import JSON
from morph.body.fulltext import fulltext
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import MorphError
from morph.model.diagnose import diagnose
from morph.model.diagnosis import Diagnosis
from morph.physics.effect import Effect
from morph.physics.kinds import JointEffect

EXAMPLE = """example:
  python -m experiments.dfki
  python -m experiments.dfki --design C.0 --json
"""
FOLDER = "dfki_double_pendulum"
HELD_BY_JOINT = ("frictionloss", "damping")
"""What findings at a joint become in a description; the nominal ones have neither."""


@dataclass(frozen=True, kw_only=True)
class Design:
    """One rig and how its runs are used."""

    robot: str
    """Its name on the shelf."""
    binding: str
    """Its binding's file."""
    train: tuple[str, ...]
    """Runs to fit."""
    held_out: tuple[str, ...]
    """Runs to open afterwards."""
    horizon: float | None
    """Seconds of the rollouts that are scored; None for whole runs."""
    also: tuple[tuple[tuple[str, ...], float], ...] = ()
    """Other runs and horizons, scored with the corrected model."""
    goal: tuple[float, float] | None = None
    """RMSE of each joint to stay below, rad."""
    reported: Mapping[str, tuple[float, float]] | None = None
    """RMSE that others reached on the same held-out runs, rad."""


DESIGNS = {
    "C.0": Design(
        robot="double_pendulum",
        binding="dfki_c0",
        train=("run_00", "run_01", "run_02", "run_04"),
        held_out=("run_03", "run_05", "run_06"),
        horizon=None,
        also=((("run_03", "run_05", "run_06"), 1.0), (("run_12", "run_13"), 0.5)),
        goal=(0.035, 0.055),
        reported={
            "rigid refit, as once reported": (0.264, 0.476),
            "published fit of the rig": (0.076, 0.122),
        },
    ),
    "A.0": Design(
        robot="double_pendulum_a0",
        binding="dfki_a0",
        train=("run_00", "run_01", "run_02", "run_04"),
        held_out=("run_03", "run_12", "run_13"),
        horizon=1.0,
    ),
}
"""Each design by its name; what is done with them is the same."""


def moved_to_the_wrong_joint(model: Model) -> Model:
    """Return a control: what was found at each joint acts on the other.

    Friction cannot change its sign, so the finding is put in the wrong place instead.
    """
    first, second = (joint.name for joint in model.robot.joints)
    spec = spec_of(model.robot)
    for figure in HELD_BY_JOINT:
        one, two = spec.joint(first), spec.joint(second)
        held = [getattr(joint, figure) + 0.0 for joint in (one, two)]
        setattr(one, figure, held[1])
        setattr(two, figure, held[0])
    spec.compile()
    other = {first: second, second: first}
    effects: list[Effect] = [
        replace(effect, joint=other[effect.joint]) if isinstance(effect, JointEffect) else effect  # type: ignore[type-var]
        for effect in model.effects
    ]
    return Model(robot=from_mjcf(fulltext(spec)), effects=tuple(effects))


def studied(design: Design, root: Path, *, quiet: bool = False) -> JSON:
    """Return what a diagnosis with default settings makes of one design, and its controls."""
    robot = load_robot(design.robot)
    train, aside = (
        bound(design.binding, FOLDER, robot, names, root=root)
        for names in (design.train, design.held_out)
    )
    found = diagnose(
        robot, train, held_out=aside, horizon=design.horizon, progress=None if quiet else _Said()
    )
    return {
        "robot": design.robot,
        "train": design.train,
        "held_out": design.held_out,
        "horizon_s": design.horizon,
        "diagnosis": found.as_json(),
        "goal": design.goal,
        "reported": dict(design.reported or {}),
        "scores": [
            _scores(design, robot, found, names, horizon, root)
            for names, horizon in ((design.held_out, design.horizon), *design.also)
        ],
    }


def _scores(
    design: Design,
    robot: Robot,
    found: Diagnosis,
    names: Sequence[str],
    horizon: float | None,
    root: Path,
) -> JSON:
    """Return errors over some runs at some horizon of the models that can be rebuilt."""
    runs = laid(bound(design.binding, FOLDER, robot, names, root=root), robot)
    best = corrected(found)
    models = {
        "nominal": Model(robot=robot),
        "corrected": best,
        "control: finding at the wrong joint": moved_to_the_wrong_joint(best),
    }
    rmse = {name: errors(model, runs, horizon) for name, model in models.items()}
    if tuple(names) == design.held_out and horizon == design.horizon:
        refitted = found.held_out_rmse["refitted"]
        rmse["control: rigid refit"] = {
            joint.name: refitted[f"{joint.name}.position"] for joint in robot.joints
        }
    return {"runs": tuple(names), "horizon_s": horizon, "rmse": rmse}


def report(name: str, result: JSON) -> None:
    """Print one design's findings and its table of errors."""
    found = result["diagnosis"]
    print(f"\ndesign {name}: {found['verdict']}, {found['seconds']:.0f} s")
    print(f"  fitted {', '.join(result['train'])}; held out {', '.join(result['held_out'])}")
    for finding in found["findings"]:
        figures = ", ".join(
            f"{symbol} {e['value']:.3g} [{e['low90']:.3g}, {e['high90']:.3g}] {e['unit']}"
            for symbol, e in finding["parameters"].items()
        )
        print(
            f"  found {finding['effect']} at {finding['where']['name']}: {figures}, "
            f"probability {finding['probability']:.2f}"
        )
        rivals = ", ".join(
            f"{r['effect']} at {r['where']['name']} ({r['probability']:.2f})"
            for r in finding["rivals"]
        )
        print(f"    rivals: {rivals or 'none'}")
    for score in result["scores"]:
        where = f"{', '.join(score['runs'])}; {span(score['horizon_s'])}"
        print(f"  RMSE, rad, over {where}:")
        joints = next(iter(score["rmse"].values()))
        print(f"  {'':34} " + "  ".join(f"{joint:>8}" for joint in joints))
        for model, by_joint in score["rmse"].items():
            print(in_row(model, by_joint))
        if score is result["scores"][0] and result["goal"]:
            for title, row in {**result["reported"], "goal": result["goal"]}.items():
                print(in_row(title, dict(zip(joints, row, strict=True))))


class _Said:
    """Says on the error stream what is being done, a line a stage."""

    def __init__(self) -> None:
        self._began, self._last = time.monotonic(), ""

    def __call__(self, what: str, share: float) -> None:
        if what != self._last:
            seconds = time.monotonic() - self._began
            sys.stderr.write(f"[{seconds:5.1f} s, {100 * share:3.0f} %] {what}\n")
            self._last = what


def main(arguments: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.dfki",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--design", choices=DESIGNS, help="only this design (default: both)")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument("--quiet", action="store_true", help="show no progress")
    asked = parser.parse_args(arguments)
    results = {}
    try:
        root = data_root()
        if not (root / FOLDER).is_dir():
            raise DataError(
                "the recordings are not there",
                where=str(root / FOLDER),
                fix=f"run python -m experiments.data --set {FOLDER}",
            )
        for name, design in DESIGNS.items():
            if asked.design in (None, name):
                results[name] = studied(design, root, quiet=asked.quiet)
    except MorphError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    if asked.json:
        print(json.dumps(results, indent=1))
    else:
        for name, result in results.items():
            report(name, result)
    return 0


if __name__ == "__main__":
    sys.exit(main())
