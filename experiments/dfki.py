"""The double pendulum of DFKI: what was left out of its description, on two designs."""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from experiments.dfki_published import PUBLISHED, by_its_equations, with_friction
from experiments.dfki_report import headline, report
from experiments.figures.save_options import parse_and_save
from experiments.incumbent import by_sysid
from experiments.needs import need_recordings
from experiments.openloop import Model, bound, corrected, errors, from_mjcf, laid
from morph.arrays import JSON
from morph.body.fulltext import fulltext
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import MorphError
from morph.inference.diagnose import diagnose
from morph.model.diagnosis import Diagnosis
from morph.model.score import rmse
from morph.model.segments import scored_segments
from morph.physics.effect import Effect
from morph.physics.kinds import JointEffect
from morph.record.recording import Recording

EXAMPLE = """example:
  python -m experiments.dfki
  python -m experiments.dfki --design C.0 --json
"""
FOLDER = "dfki_double_pendulum"
NOMINAL, CORRECTED = "described, friction left out", "corrected"
PUBLISHER = "publisher's own equations"
SYSID, SYSID_FIXED = "sysid, friction a candidate", "sysid, published friction held"
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


DESIGNS = {
    "C.0": Design(
        robot="double_pendulum",
        binding="dfki_c0",
        train=("run_00", "run_01", "run_02", "run_04"),
        held_out=("run_03", "run_05", "run_06"),
        horizon=None,
        also=((("run_03", "run_05", "run_06"), 1.0), (("run_12", "run_13"), 0.5)),
        goal=(0.035, 0.055),
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


def rivals(name: str, robot: Robot, train: Sequence[Recording]) -> tuple[dict[str, Model], JSON]:
    """Return models that others would use, and what `mujoco.sysid` fitted for two of them.

    One sysid is told that friction is a candidate; the other keeps the publisher's friction
    and moves the rest, which shows what that friction leaves over.
    """
    rig = PUBLISHED[name]
    as_published = with_friction(robot, rig.level, rig.viscous)
    models = {
        "published factors read as levels": with_friction(robot, rig.coulomb, rig.viscous),
        "published friction": as_published,
    }
    told = {}
    for title, start, fixed in (
        (SYSID, robot, ()),
        (SYSID_FIXED, as_published.robot, HELD_BY_JOINT),
    ):
        began = time.monotonic()
        models[title], values = by_sysid(start, laid(train, start), fixed=fixed)
        told[title] = {"seconds": time.monotonic() - began, "values": values}
    return models, told


def studied(name: str, root: Path, *, quiet: bool = False) -> JSON:
    """Return what a diagnosis with default settings makes of one design, rivals and controls."""
    design = DESIGNS[name]
    robot = load_robot(design.robot)
    train, aside = (
        bound(design.binding, FOLDER, robot, names, root=root)
        for names in (design.train, design.held_out)
    )
    found = diagnose(
        robot, train, held_out=aside, horizon=design.horizon, progress=None if quiet else _Said()
    )
    others, told = rivals(name, robot, train)
    best = corrected(found)
    models = {
        NOMINAL: Model(robot=robot),
        **others,
        CORRECTED: best,
        "control: finding at the wrong joint": moved_to_the_wrong_joint(best),
    }
    return {
        "robot": design.robot,
        "train": design.train,
        "held_out": design.held_out,
        "horizon_s": design.horizon,
        "diagnosis": found.as_json(),
        "goal": design.goal,
        "published": {"coulomb_factor": PUBLISHED[name].coulomb, "level": PUBLISHED[name].level},
        "sysid": told,
        "scores": [
            scores(name, models, found, names, horizon, root)
            for names, horizon in ((design.held_out, design.horizon), *design.also)
        ],
    }


def scores(
    name: str,
    models: Mapping[str, Model],
    found: Diagnosis,
    names: Sequence[str],
    horizon: float | None,
    root: Path,
) -> JSON:
    """Return errors over some runs at some horizon, and how many times those of the corrected."""
    design, robot = DESIGNS[name], models[NOMINAL].robot
    runs = laid(bound(design.binding, FOLDER, robot, names, root=root), robot)
    joints = [joint.name for joint in robot.joints]
    errors_of = {title: errors(model, runs, horizon) for title, model in models.items()}
    segments = scored_segments(runs, horizon)
    own = rmse(segments, by_its_equations(PUBLISHED[name], segments))
    errors_of[PUBLISHER] = dict(zip(joints, map(float, own), strict=True))
    if tuple(names) == design.held_out and horizon == design.horizon:
        refitted = found.held_out_rmse["refitted"]
        errors_of["control: rigid refit"] = {
            joint: refitted[f"{joint}.position"] for joint in joints
        }
    return {
        "runs": tuple(names),
        "horizon_s": horizon,
        "rmse": errors_of,
        "times_corrected": {
            title: {joint: row[joint] / errors_of[CORRECTED][joint] for joint in joints}
            for title, row in errors_of.items()
        },
    }


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
    asked, save = parse_and_save(parser, arguments, module="experiments.dfki")
    results = {}
    try:
        root = need_recordings(FOLDER)
        for name in DESIGNS:
            if asked.design in (None, name):
                results[name] = studied(name, root, quiet=asked.quiet)
        if save:
            save(**headline(results))
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
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
