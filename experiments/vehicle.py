"""A BlueROV2 in a tank, diagnosed: are drag and its thrusters' dead zone named without being told?

The description floats and is pushed by its thrusters; what the water does is left out. The slow
session, whose commands are a quarter, and the fast one's first three fifths, with commands up to
three quarters, are fitted; the fast one's last two fifths are held out: surge velocity, along the
hull, of rollouts of ten seconds, by differences of positions as the recorded one. Controls: as
described, thrust refitted, told the drag and added mass that others published for this vehicle
with thrust refitted, and the publishers' own simulations of the same part.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from experiments.figures.save_options import parse_and_save
from experiments.needs import need_recordings
from experiments.openloop import bound, corrected
from morph.arrays import JSON, Array
from morph.body.load import load
from morph.errors import MorphError
from morph.inference.diagnose import diagnose
from morph.model.episodes import episode, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.nuisance_parameters import knobs
from morph.model.score import rollouts
from morph.model.segments import Segments, scored_segments
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.linear_drag import LinearDrag
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.record.recording import Channel, Recording
from morph.sim.tangent import conjugate, product, turned

EXAMPLE = """examples:
  python -m experiments.vehicle
  python -m experiments.vehicle --session slow --json"""
FOLDER, DESCRIPTION = "bluerov2_saabmarine", Path(__file__).with_name("bluerov2")
PARTS, FITTED = 5, 3
"""Into how many parts the session held out is cut, and how many of the first are fitted."""
FILES = {"slow": "2025_05_27-11_10_52_sync", "fast": "2025_05_27-11_57_50"}
"""The files of the sessions."""
HORIZON = 10.0
"""Seconds of the held-out rollouts."""
VARY = {"gain": 0.5}
"""Fractions by which the description may be wrong: what a command thrusts is assumed."""
PUSHED, TOLD = "thrust refitted", "told the published drag"
THEIRS = ("zero_shot", "knn", "mtgp", "svgp")
"""The publishers' simulations: their equations, and three kinds of residual learned beside them."""


def parts_of(recording: Recording) -> list[Recording]:
    """Return a recording cut into parts of one length."""
    edges = np.linspace(recording.start, recording.end, PARTS + 1)
    return [
        replace(
            recording,
            name=f"{recording.name}_{number}",
            sha256="",
            channels={
                name: _within(channel, *ends) for name, channel in recording.channels.items()
            },
        )
        for number, ends in enumerate(itertools.pairwise(edges))
    ]


def _within(channel: Channel, begin: float, end: float) -> Channel:
    kept = (channel.time >= begin) & (channel.time <= end)
    return replace(channel, time=channel.time[kept], value=channel.value[kept])


def published() -> tuple[Effect, ...]:
    """Return the water's forces on this vehicle, without those between its motions.

    Source: von Benzon et al. 2022, Journal of Marine Science and Engineering 10(12), 1898;
    theirs has z down, which changes none of these.
    """
    return (
        AddedMass(body="hull", x=6.36, y=7.12, z=18.68, rx=0.189, ry=0.135, rz=0.222),
        LinearDrag(body="hull", x=13.7, y=0.0, z=33.0, rx=0.0, ry=0.8, rz=0.0),
        QuadraticDrag(body="hull", x=141.0, y=217.0, z=190.0, rx=1.19, ry=0.47, rz=1.5),
    )


def surge(segments: Segments, reading: Array) -> Array:
    """Return the velocity along the hull by what is read of it, m/s, (segments, readings).

    Args:
        segments: Rollouts.
        reading: Places and rotations from the measured orientations, (segments, readings, 6).
    """
    turn = product(turned(reading[..., 3:6]), segments.attitude[..., 0, :])
    time = segments.step * (segments.before + segments.part)
    found = np.full(time.shape, np.nan)
    for row in range(len(segments)):
        at = np.flatnonzero(segments.valid[row].all(axis=1))
        rate = np.zeros((len(at), 4))
        rate[:, 1:] = np.gradient(reading[row, at, :3], time[row, at], axis=0)
        along = product(product(conjugate(turn[row, at]), rate), turn[row, at])
        found[row, at] = along[:, 1]
    return found


def with_thrust(hypothesis: Hypothesis, segments: Segments) -> Array:
    """Return the point at which rollouts err least by what commands thrust alone."""
    gains = [at for at, knob in enumerate(hypothesis.knobs) if knob.name.startswith("gain:")]

    def at(values: Array) -> Array:
        point = hypothesis.start.copy()
        point[gains] = values
        return point

    def error(values: Array) -> Array:
        predicted = rollouts({"": (hypothesis, at(values))}, segments)[""]
        off = np.where(segments.valid, segments.reading - predicted, 0.0)[..., :3]
        return np.asarray(off.ravel())

    found = least_squares(error, np.zeros(len(gains)), diff_step=1e-3, max_nfev=20)
    return at(found.x)


def studied(root: Path, session: str) -> JSON:
    """Return what is found without one session's last parts, and errors of surge in them."""
    robot = load(DESCRIPTION)
    others = [name for name in FILES if name != session]
    whole, *rest = bound("bluerov2", FOLDER, robot, [session, *others], root=root)
    parts = parts_of(whole)
    fitted, aside = [*rest, *parts[:FITTED]], parts[FITTED:]
    found = diagnose(robot, fitted, held_out=aside, horizon=HORIZON, vary=VARY)
    step = step_for(fitted, robot)
    train, segments = (
        scored_segments([episode(each, robot, step) for each in some], HORIZON)
        for some in (fitted, aside)
    )
    nominal = Hypothesis(robot=robot, step=step, knobs=knobs(robot, VARY))
    told = replace(nominal, effects=published())
    best = corrected(found)
    laid = Hypothesis(robot=best.robot, step=step, knobs=(), effects=best.effects)
    models = {
        "as described": (nominal, nominal.start),
        PUSHED: (nominal, with_thrust(nominal, train)),
        TOLD: (told, with_thrust(told, train)),
        "corrected": (laid, laid.start),
    }
    true = surge(segments, segments.reading)
    errors = {
        name: float(np.sqrt(np.nanmean((surge(segments, each) - true) ** 2)))
        for name, each in rollouts(models, segments).items()
    }
    return {
        "session": session,
        "found": [
            {
                "effect": each.effect.label,
                "probability": each.probability,
                **{name: estimate.value for name, estimate in each.parameters.items()},
            }
            for each in found.findings
        ],
        "verdict": found.verdict,
        "in_noise": found.unexplained.in_noise,
        "seconds": found.seconds,
        "surge": {**errors, **theirs(root, session)},
        "deviation": float(np.nanstd(true)),
    }


def theirs(root: Path, session: str) -> dict[str, float]:
    """Return the errors of the publishers' simulations of surge in the held-out part, m/s."""
    with np.load(root / FOLDER / f"rosbag2_{FILES[session]}_0_3dof_data_all.npz") as data:
        real = np.array(data["real_vel"])[:, 0]
        made = {name: np.array(data[f"sim_vel_{name}"])[:, 0] for name in THEIRS}
    first = len(real) * FITTED // PARTS
    return {
        f"their {name}": float(np.sqrt(np.mean((each - real)[first:] ** 2)))
        for name, each in made.items()
    }


def headline(result: JSON) -> JSON:
    """Return what a result file holds."""
    names = [each["effect"] for each in result["found"]]
    figures = {
        "drag": any("drag" in name for name in names),
        "dead_zone": sum(name.startswith("dead_zone@") for name in names),
        "found": ", ".join(names),
        "surge": result["surge"]["corrected"],
        "deviation": result["deviation"],
        "seconds": result["seconds"],
    }
    controls = {name: {"surge": e} for name, e in result["surge"].items() if name != "corrected"}
    return {"figures": figures, "controls": controls, "rows": [result], "seeds": []}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the study and return its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.vehicle",
        description=__doc__,
        epilog=EXAMPLE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--session", choices=tuple(FILES), default="fast", help="whose last parts are held out"
    )
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")
    asked, save = parse_and_save(parser, arguments, module="experiments.vehicle")
    try:
        result = studied(need_recordings(FOLDER), asked.session)
        if save:
            save(**headline(result))
    except MorphError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if asked.json:
        print(json.dumps(result, indent=1))
        return 0
    print(f"{result['session']} session: {result['verdict']}, {result['seconds']:.0f} s")
    for each in result["found"]:
        rest = ", ".join(f"{k} {v:.4g}" for k, v in each.items() if k != "effect")
        print(f"  {each['effect']}: {rest}")
    print(
        f"surge velocity over {HORIZON:g} s, held out, RMS ({result['deviation']:.3f} m/s moves):"
    )
    for name, surge_error in result["surge"].items():
        print(f"  {name:44}{surge_error:8.3f} m/s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
