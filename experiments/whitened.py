"""How often whitened columns rank a concealed effect first, before anything is simulated.

The thinnest whole path of `morph.inference`: each run is smoothed by the description as it stands
and linearised once; every effect at every place is a column, or a few; one Gram matrix in the
metric of the readings tells what each explains beside the description's own figures. No candidate
is simulated. Seeds below 1000 are for building.

Example: python -m experiments.whitened --seed 900 --cases 10
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from experiments.conceal import generate, make_cases, open_seal
from morph.arrays import JSON, Array
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.inference.filter import Whitened, whitened
from morph.inference.linearise import linearised
from morph.inference.reference import Reference, SampledRun, reference
from morph.model.episodes import Episode, episode, moving_joints, step_for
from morph.model.hypothesis import Hypothesis
from morph.model.knobs import knobs
from morph.physics import EFFECTS
from morph.physics.body_motion import body_motions
from morph.physics.effect import Effect
from morph.physics.motion import Motion
from morph.record.binding import load_binding
from morph.record.load import load as load_recordings
from morph.record.recording import Recording

LEVELS = (1.0, 0.3, 0.1, 0.03)
"""Scales of the missing force, as shares of what is likeliest without any effect. An effect that
explains it needs less: each is judged at the scale under which it is likeliest."""
NUDGE = 1e-3
"""Step of the difference by an own figure's logarithm."""


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """One effect at its likeliest strength."""

    effect: Effect
    """The effect; shapes of its law as in the best entry of their grid."""
    gain: float
    """Logarithm of the evidence beyond that of the description's own figures, less its price."""


def ranked(robot: Robot, recordings: Sequence[Recording]) -> list[Ranked]:
    """Return every effect at every place, the one with the most evidence first."""
    step = step_for(recordings, robot)
    nominal = Hypothesis(robot=robot, step=step, knobs=knobs(robot))
    effects = list(_dictionary(robot))
    runs = [_whitened(nominal, effects, episode(each, robot, step)) for each in recordings]
    levels = [
        sum(runs[1:], start=runs[0]) for runs in zip(*(each for each, _ in runs), strict=True)
    ]
    places = runs[0][1]
    trust = np.array([1.0 / knob.fraction**2 for knob in nominal.knobs])
    best: dict[str, Ranked] = {}
    none = max(_without(level, trust)[0] for level in levels)
    for level in levels:
        evidence, rest = _without(level, trust)
        for effect, place in zip(effects, places, strict=True):
            gain = evidence - none + _gain(effect, rest[np.ix_(place, place)], rest[place, 0])
            gain -= 0.5 * len(place) * math.log(level.readings)
            if effect.label not in best or gain > best[effect.label].gain:
                best[effect.label] = Ranked(effect=effect, gain=gain)
    return sorted(best.values(), key=lambda each: -each.gain)


def _dictionary(robot: Robot) -> Iterator[Effect]:
    """Give every effect at every place, with each shape of its grid."""
    for kind in EFFECTS:
        scanned = [p for p in kind.parameters() if p.scan and p.name not in kind.strengths]
        for place in kind.suspects(robot):
            for values in itertools.product(*(p.scan for p in scanned)):
                shape = dict(zip((p.name for p in scanned), values, strict=True))
                yield replace(kind.at(place), **shape)  # type: ignore[type-var]


def _without(level: Whitened, trust: Array) -> tuple[float, Array]:
    """Return the evidence with own figures alone, and the Gram matrix of what they leave."""
    own = slice(1, 1 + len(trust))
    inner = level.gram[own, own] + np.diag(trust)
    rest = level.gram - level.gram[:, own] @ np.linalg.solve(inner, level.gram[own, :])
    return -0.5 * (rest[0, 0] + level.logarithm), rest


def _gain(effect: Effect, inner: Array, along: Array) -> float:
    """Return what an effect adds to the log likelihood at its best strengths within bounds."""
    size = np.sqrt(np.maximum(np.diag(inner), 1e-300))
    seen = size > 1e-6 * size.max()
    scaled = inner[np.ix_(seen, seen)] / np.outer(size[seen], size[seen])
    free = np.zeros(len(along))
    free[seen] = np.linalg.lstsq(scaled, along[seen] / size[seen], rcond=1e-9)[0] / size[seen]
    strengths = effect.with_strengths(free).coefficients
    return max(0.0, float(strengths @ along - 0.5 * strengths @ inner @ strengths))


def _whitened(
    nominal: Hypothesis, effects: Sequence[Effect], read: Episode
) -> tuple[list[Whitened], list[Array]]:
    """Return one run's Gram matrices, one a level, and the columns of each effect."""
    model, robot = nominal.at(nominal.start).model, nominal.robot
    joints = moving_joints(robot)
    run, guess = _run_of(read)
    about = reference(model, run, guess)
    samples, dofs = guess.shape
    still = np.zeros((samples, dofs, 1))
    moved, shown = [-about.acceleration[:, :, None]], [about.error[:, :, None]]
    base = linearised(model, about.position, about.velocity, run.command, every=samples)
    for at in range(len(nominal.knobs)):
        point = nominal.start.copy()
        point[at] = NUDGE
        turned = nominal.at(point).model
        other = linearised(turned, about.position, about.velocity, run.command, every=samples)
        moved.append((other.acceleration - base.acceleration)[:, :, None] / NUDGE)
        shown.append(still)
    motion = _motion(model, robot, about, run)
    mobility = about.tangent.jacobian[:, :, 2 * dofs :]
    places, at = [], len(moved)
    for effect in effects:
        if effect.kind == "sensor":
            bias = still.copy()
            bias[:, joints.index(effect.where.split(".")[0])] = 1.0
            moved.append(still)
            shown.append(bias)
        else:
            force = effect.regressor(motion)
            moved.append(np.einsum("tij,tjk->tik", mobility, force))
            shown.append(np.zeros_like(force))
        places.append(np.arange(at, at := at + moved[-1].shape[2]))
    readings, accelerations = np.concatenate(shown, axis=2), np.concatenate(moved, axis=2)
    levels = [
        replace(about.disturbance, scale=about.disturbance.scale * level, noise=run.noise)
        for level in LEVELS
    ]
    return [whitened(about.tangent, level, readings, accelerations) for level in levels], places


def _run_of(read: Episode) -> tuple[SampledRun, Array]:
    """Return an episode on its grid, and positions to begin with."""
    samples, dofs = len(read.command), read.reading.shape[1]
    at = np.rint(read.time / read.step).astype(int)
    there = at < samples
    reading, valid = np.zeros((samples, dofs)), np.zeros((samples, dofs), dtype=bool)
    # A reading between two samples is put on the nearer one.
    late = (read.time - at * read.step)[:, None] * read.velocity
    reading[at[there]], valid[at[there]] = (read.reading - late)[there], True
    grid = read.step * np.arange(samples)
    guess = [np.interp(grid, read.time, read.position[:, dof]) for dof in range(dofs)]
    run = SampledRun(
        step=read.step,
        command=read.command,
        reads=np.eye(dofs, 2 * dofs),
        reading=reading,
        valid=valid,
        noise=read.noise,
    )
    return run, np.stack(guess, axis=1)


def _motion(model: mujoco.MjModel, robot: Robot, about: Reference, run: SampledRun) -> Motion:
    """Return a motion as effects' regressors see it."""
    samples, dofs = about.position.shape
    acceleration = np.gradient(about.velocity, run.step, axis=0)
    moment = np.zeros((model.nu, dofs))
    for actuator in range(model.nu):
        dof = model.jnt_dofadr[model.actuator_trnid[actuator, 0]]
        moment[actuator, dof] = model.actuator_gear[actuator, 0]
    drive = np.zeros((samples, model.nu, dofs))
    data = mujoco.MjData(model)
    for t in range(samples):
        data.qpos[:], data.qvel[:] = about.position[t], about.velocity[t]
        data.ctrl[:] = run.command[t]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fwdActuation(model, data)
        drive[t] = moment * data.actuator_force[:, None]
    rate = np.gradient(run.command, run.step, axis=0) * model.actuator_gainprm[:, 0]
    jacobian = about.tangent.jacobian
    stiffness = np.asarray(-np.linalg.solve(jacobian[:, :, 2 * dofs :], jacobian[:, :, :dofs]))
    links = [link.name for link in robot.links]
    return Motion(
        position=about.position,
        velocity=about.velocity,
        acceleration=acceleration,
        drive=drive,
        drive_rate=moment * rate[:, :, None],
        stiffness=stiffness,
        joints={joint.name: model.joint(joint.name).dofadr[0] for joint in robot.joints},
        actuators={actuator.name: at for at, actuator in enumerate(robot.actuators)},
        bodies=body_motions(model, links, about.position, about.velocity, acceleration),
    )


def row_of(folder: Path) -> JSON:
    """Return where the concealed effect of a case stands among all, and what stands first."""
    robot = load_robot(str(load_binding(folder / "recordings" / "recording.toml").robot))
    started = time.process_time()
    found = ranked(robot, load_recordings(folder / "recordings", robot=robot))
    spent = time.process_time() - started
    truth = open_seal(folder).case
    labels = [each.effect.label for each in found]
    label = f"{truth.effect}@{truth.place}"
    return {
        "case": folder.name,
        "truth": label,
        "rank": labels.index(label) + 1 if label in labels else None,
        "first": {each.effect.label: round(each.gain, 1) for each in found[:3]},
        "cpu_s": round(spent, 1),
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Print a line of JSON for each case, and the shares that are first and in the first three."""
    parser = argparse.ArgumentParser(
        prog="python -m experiments.whitened",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seed", type=int, default=900, metavar="N", help="random seed of cases")
    parser.add_argument("--cases", type=int, default=10, metavar="N", help="number of cases")
    options = parser.parse_args(arguments)
    ranks = []
    with tempfile.TemporaryDirectory() as folder:
        cases = make_cases(options.cases, options.seed, clean=False)
        generate(cases, Path(folder))
        for case in cases:
            row = row_of(Path(folder) / case.name)
            ranks.append(row["rank"] or math.inf)
            print(json.dumps(row), flush=True)
    shares = {most: sum(rank <= most for rank in ranks) / len(ranks) for most in (1, 3)}
    print(json.dumps({"first": shares[1], "in_the_first_three": shares[3], "cases": len(ranks)}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
