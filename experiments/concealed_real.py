"""Something concealed in real recordings: DFKI's double pendulum, design C.0.

One encoder's readings are taken away, stamped late or scaled; the description loses a part of a
link's mass, or states a rotor's inertia that is not there; and runs of another rig, design A.0,
stand for a session in which the robot had changed. Whether each is named, where it is and how
large, and what the recovered joint's motion errs by. The control is the same recordings with
nothing concealed, in which none of these may be named.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.dfki import DESIGNS, FOLDER
from experiments.figures.save_options import parse_and_save
from experiments.needs import need_recordings
from experiments.openloop import bound, from_mjcf
from morph.arrays import JSON
from morph.body.fulltext import fulltext
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import MorphError
from morph.inference.diagnose import diagnose
from morph.inference.prepared import completed
from morph.model.diagnosis import Diagnosis
from morph.record.recording import Channel, Recording

EXAMPLE = """example:
  python -m experiments.concealed_real --only nothing hidden"""

DESIGN = DESIGNS["C.0"]
"""Which runs are fitted, and which are held out."""
JOINT = "elbow"
LATE, SCALE, LIGHTER, ROTOR = 0.03, 1.05, 0.75, 0.02
"""s; the factor on its readings; that on its link's mass; kg m2 of a rotor."""
LIKELY = 0.3
"""Probability above which a law is named, alone or beside one that is as likely."""


@dataclass(frozen=True, kw_only=True)
class Concealed:
    """Recordings and a description in which something is concealed."""

    robot: Robot
    """The description."""
    fitted: Sequence[Recording]
    """Runs that are fitted."""
    aside: Sequence[Recording]
    """Runs that are held out."""
    names: tuple[str, ...] = ()
    """Labels of the laws that are right; empty where nothing is to be named."""
    value: tuple[str, float] | None = None
    """A parameter of it, and its true value."""
    changes: bool = False
    """Whether the robot is to be said to have changed."""


def nothing(robot: Robot, fitted: Sequence[Recording], aside: Sequence[Recording]) -> Concealed:
    """Return the recordings as they are."""
    return Concealed(robot=robot, fitted=fitted, aside=aside)


def hidden(robot: Robot, fitted: Sequence[Recording], aside: Sequence[Recording]) -> Concealed:
    """Return recordings without the elbow's encoder; friction there is to be named all the same."""

    def without(run: Recording) -> Recording:
        names = [name for name in run.channels if not name.startswith(f"{JOINT}.")]
        names.append(f"{JOINT}.command")
        return replace(run, channels={name: run.channels[name] for name in names})

    return Concealed(
        robot=robot,
        fitted=[without(run) for run in fitted],
        aside=[without(run) for run in aside],
        names=(f"coulomb_friction@{JOINT}", f"stribeck_friction@{JOINT}"),
    )


def late(robot: Robot, fitted: Sequence[Recording], aside: Sequence[Recording]) -> Concealed:
    """Return recordings whose elbow is stamped late."""
    return _misread(
        robot,
        fitted,
        aside,
        "timestamp_offset",
        "T",
        LATE,
        lambda e: replace(e, time=e.time + LATE),
    )


def scaled(robot: Robot, fitted: Sequence[Recording], aside: Sequence[Recording]) -> Concealed:
    """Return recordings whose elbow's encoder counts too much."""
    return _misread(
        robot,
        fitted,
        aside,
        "sensor_scale",
        "gain",
        SCALE,
        lambda e: replace(e, value=SCALE * e.value),
    )


def _misread(
    robot: Robot,
    fitted: Sequence[Recording],
    aside: Sequence[Recording],
    law: str,
    parameter: str,
    value: float,
    change: Callable[[Channel], Channel],
) -> Concealed:
    """Return recordings whose elbow's encoder reads otherwise than it did."""

    def changed(run: Recording) -> Recording:
        name = f"{JOINT}.position"
        return replace(run, channels={**run.channels, name: change(run.channels[name])})

    return Concealed(
        robot=robot,
        fitted=[changed(run) for run in fitted],
        aside=[changed(run) for run in aside],
        names=(f"{law}@{JOINT}.position",),
        value=(parameter, value),
    )


def lighter(robot: Robot, fitted: Sequence[Recording], aside: Sequence[Recording]) -> Concealed:
    """Return a description whose last link lacks a part of its mass."""
    spec = spec_of(robot)
    link = robot.joints[-1].link
    body = spec.body(link)
    body.mass *= LIGHTER
    body.inertia = [LIGHTER * each for each in body.inertia]
    spec.compile()
    return Concealed(
        robot=from_mjcf(fulltext(spec)),
        fitted=fitted,
        aside=aside,
        names=(f"link_inertia@{link}", f"payload@{link}"),
    )


def rotor(robot: Robot, fitted: Sequence[Recording], aside: Sequence[Recording]) -> Concealed:
    """Return a description with a rotor's inertia at the elbow that the robot has not."""
    spec = spec_of(robot)
    spec.joint(JOINT).armature += ROTOR
    spec.compile()
    return Concealed(
        robot=from_mjcf(fulltext(spec)), fitted=fitted, aside=aside, names=(f"armature@{JOINT}",)
    )


def spliced(robot: Robot, fitted: Sequence[Recording], aside: Sequence[Recording]) -> Concealed:
    """Return runs of which the last are of another rig, with longer links."""
    root = need_recordings(FOLDER)
    others = bound("dfki_a0", FOLDER, robot, ["run_00", "run_01"], root=root)
    renamed = [
        replace(run, name=f"later_{at}", session=fitted[0].session) for at, run in enumerate(others)
    ]
    return Concealed(robot=robot, fitted=[*fitted[:2], *renamed], aside=aside, changes=True)


CASES: dict[str, Callable[..., Concealed]] = {
    each.__name__: each for each in (nothing, hidden, late, scaled, lighter, rotor, spliced)
}


def studied(name: str) -> JSON:
    """Return what a diagnosis says of one case."""
    root, robot = need_recordings(FOLDER), load("double_pendulum")
    fitted, aside = (
        bound(DESIGN.binding, FOLDER, robot, names, root=root)
        for names in (DESIGN.train, DESIGN.held_out)
    )
    case, began = CASES[name](robot, fitted, aside), time.process_time()
    found = diagnose(case.robot, case.fitted, held_out=case.aside, horizon=DESIGN.horizon)
    row: JSON = {
        "case": name,
        "found": [each.effect.label for each in found.findings],
        "probability": [each.probability for each in found.findings],
        "verdict": found.verdict,
        "changes": [list(each.said(set())) for each in found.changes],
        "cpu_seconds": time.process_time() - began,
        "named": _named(case, found),
        "rmse": dict(found.held_out_rmse["corrected"]),
    }
    if case.value is not None:
        row |= {"true": case.value[1], "estimate": _estimate(case, found)}
    if name == "hidden":
        row["recovered_rad"], row["moves_rad"] = _recovered(case, fitted)
    return row


def _named(case: Concealed, found: Diagnosis) -> bool:
    """Return whether what was concealed is a likely finding or rival, or a change."""
    if case.changes:
        return bool(found.changes)
    labels = {f.effect.label for f in found.findings if f.probability > LIKELY}
    labels |= {
        f"{rival.effect}@{rival.where}"
        for each in found.findings
        for rival in each.rivals
        if rival.probability > LIKELY
    }
    return bool(labels & set(case.names))


def _estimate(case: Concealed, found: Diagnosis) -> float | None:
    name = case.value[0] if case.value else ""
    return next(
        (f.parameters[name].value for f in found.findings if f.effect.label in case.names), None
    )


def _recovered(case: Concealed, fitted: Sequence[Recording]) -> tuple[float, float]:
    """Return the RMS error of the hidden joint's motion by the description, and its own RMS."""
    errors, moves = [], []
    for run, whole in zip(case.fitted, fitted, strict=True):
        guess = completed(run, case.robot).channels[f"{JOINT}.position"]
        true = whole.channels[f"{JOINT}.position"].at(guess.time)
        errors.append(guess.value - true)
        moves.append(true - true.mean())
    error, moved = (float(np.sqrt(np.mean(np.concatenate(e) ** 2))) for e in (errors, moves))
    return error, moved


def main(argv: list[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.concealed_real",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--only", nargs="+", choices=list(CASES), default=list(CASES))
    asked, save = parse_and_save(parser, argv, module="experiments.concealed_real")
    rows = []
    try:
        for name in asked.only:
            rows.append(studied(name))
            print(json.dumps(rows[-1]), flush=True)
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if save:
        plain = [row for row in rows if row["case"] == "nothing"]
        wrong = {name for row in plain for name in row["found"] if "friction" not in name}
        cases = [row for row in rows if row["case"] != "nothing"]
        figures: JSON = {"cases": len(cases), "named": sum(row["named"] for row in cases)}
        for row in cases:
            if "recovered_rad" in row:
                figures |= {key: row[key] for key in ("recovered_rad", "moves_rad")}
        save(
            figures=figures,
            controls={"nothing concealed": {"named_wrongly": len(wrong)}},
            rows=rows,
            seeds=[0],
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
