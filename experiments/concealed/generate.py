"""Cases as plain files, and their truths in a folder apart."""

from __future__ import annotations

import functools
import gzip
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from loky import ProcessPoolExecutor

from experiments.concealed.body_laws import PADDLE, WATER
from experiments.concealed.case import SECONDS, Case, draw_case
from experiments.concealed.mechanism import SERVO
from experiments.concealed.mjcf import describe
from experiments.concealed.plant import Array
from experiments.concealed.readings import (
    DIGITS,
    POSE,
    ideal_readings,
    link_poses,
    seen_by_camera,
    write_down,
)
from experiments.concealed.seal import CASES, TRUTHS, truth_of
from experiments.concealed.simulate import GRID
from experiments.concealed.truth import HORIZON, predict, replayed, window_starts
from morph.files import sha256, write_whole

SCHEMA = "concealed.case/1"


def generate(
    suite: str,
    seed: int,
    numbers: Sequence[int],
    folder: Path,
    *,
    seconds: float = SECONDS,
    workers: int = 1,
) -> list[Path]:
    """Write cases of a suite that are not there yet, and return their folders.

    Args:
        suite: Name of the suite.
        seed: Random seed.
        numbers: Numbers of the cases.
        folder: Where `cases` and `truth` are.
        seconds: Length of each of the five runs of a case, s.
        workers: How many processes write cases.
    """
    folders = [folder / CASES / f"{suite}_{seed}_{number:04d}" for number in numbers]
    # A case's own file is written last.
    missing = [
        number
        for number, path in zip(numbers, folders, strict=True)
        if not (path / "case.json").exists()
    ]
    write = functools.partial(_write_drawn, suite, seed, folder=folder, seconds=seconds)
    if min(workers, len(missing)) > 1:
        with ProcessPoolExecutor(workers) as pool:
            list(pool.map(write, missing))
    else:
        for number in missing:
            write(number)
    return folders


def _write_drawn(suite: str, seed: int, number: int, *, folder: Path, seconds: float) -> None:
    write_case(draw_case(suite, seed, number, seconds=seconds), folder)


def write_case(case: Case, folder: Path) -> Path:
    """Write a case and its truth, and return the case's folder."""
    path, truths = folder / CASES / case.name, folder / TRUTHS
    recordings = _write_recordings(case, path / "recordings")
    true, oracle, errors = _write_held_out(case, path / "held_out")
    arrays = _npz({"position": true, "oracle": oracle})
    write_whole(truths / f"{case.name}.npz", arrays, durable=False)
    truth = json.dumps(truth_of(case, arrays, *errors), indent=1) + "\n"
    write_whole(truths / f"{case.name}.json", truth, durable=False)
    write_whole(path / "robot.xml", describe(case.mechanism, case.name), durable=False)
    known = _known(case, recordings, sha256(truth))
    write_whole(path / "case.json", json.dumps(known, indent=1) + "\n", durable=False)
    return path


def _known(case: Case, recordings: Sequence[str], digest: str) -> dict[str, Any]:
    """Return what a solver is told, beside the description and the recordings."""
    mechanism, logger = case.mechanism, case.logger
    water = {"density": WATER, "paddle": {"link": mechanism.links[-1], "height_m": PADDLE}}
    return {
        "schema": SCHEMA,
        "name": case.name,
        "description": "robot.xml",
        "recordings": [f"recordings/{name}" for name in recordings],
        "held_out": {
            "commands": "held_out/commands.csv.gz",
            "starts": "held_out/starts.csv",
            "horizon_s": HORIZON,
        },
        "vary": dict(case.vary),
        "rate_hz": logger.rate_hz,
        "resolution": {
            f"{mechanism.joints[i]}.position": float(f"{logger.count[i]:.6g}")
            for i in _encoders(case)
        },
        "water": water if mechanism.submerged else None,
        "truth_sha256": digest,
    }


def _encoders(case: Case) -> list[int]:
    """Return the joints that have an encoder."""
    if case.way == "tracked":
        return []
    joints = list(range(case.mechanism.plant.count))
    return [i for i in joints if case.way == "read" or i != case.hidden]


def _channels(case: Case, *, velocity: bool) -> list[str]:
    mechanism = case.mechanism
    joints = [mechanism.joints[i] for i in _encoders(case)]
    names = ["time", *(f"{joint}.position" for joint in joints)]
    if velocity:
        names += [f"{joint}.velocity" for joint in joints]
    if case.way == "tracked":
        names += [f"{link}.{axis}" for link in mechanism.links for axis in POSE]
    return names + [f"{mechanism.actuator(i)}.command" for i in mechanism.driven]


def _write_recordings(case: Case, folder: Path) -> list[str]:
    truth, joints = case.truth, case.mechanism.plant.count
    header = _channels(case, velocity=case.logger.velocity)
    driven = list(case.mechanism.driven)
    binding, names = ['robot = "../robot.xml"'], []
    for number, run in enumerate(truth.runs[:-1]):
        log = write_down(run, case.motions[number], case.logger, case.rng, joints, truth.drift)
        encoders = _encoders(case)
        columns = [log.time[:, None], log.position[:, encoders]]
        columns += [] if log.velocity is None else [log.velocity[:, encoders]]
        if case.way == "tracked":
            where, _ = case.motions[number].at(run.ticks[log.kept])
            poses = link_poses(case.mechanism.plant, where[:, :joints])
            columns.append(seen_by_camera(poses, case.logger, case.rng))
        columns.append(log.command[:, driven])
        name = f"run_{number + 1}.csv.gz"
        write_whole(folder / name, _csv(header, np.hstack(columns)), durable=False)
        binding += ["", "[[episode]]", f'file = "{name}"', f'name = "run_{number + 1}"']
        names.append(name)
    binding += ["", "[columns]", *(_column(case, channel) for channel in header)]
    write_whole(folder / "recording.toml", "\n".join(binding) + "\n", durable=False)
    return names


def _write_held_out(case: Case, folder: Path) -> tuple[Array, Array, tuple[float, float]]:
    """Write what predictions start from.

    Returns:
        Readings without noise; the true plant's predictions of them; the errors of the
        description's predictions and of the true plant's.
    """
    truth, mechanism = case.truth, case.mechanism
    joints, last = mechanism.plant.count, len(case.truth.runs) - 1
    run, motion, plant = truth.runs[last], case.motions[last], truth.plant(last)
    starts = window_starts(run)
    here = ideal_readings(plant, motion.q, starts, motion.step, joints)
    after = ideal_readings(plant, motion.q, starts + 1, motion.step, joints)
    before = ideal_readings(plant, motion.q, np.maximum(starts - 1, 0), motion.step, joints)
    span = (starts + 1 - np.maximum(starts - 1, 0))[:, None] * GRID
    here, rate = here.round(DIGITS), ((after - before) / span).round(DIGITS)
    clock = 1 + truth.drift
    table = np.hstack([starts[:, None] * GRID * clock, here, rate])
    names = [f"{joint}.{each}" for each in ("position", "velocity") for joint in mechanism.joints]
    write_whole(folder / "starts.csv", _lines(["time", *names], table), durable=False)
    sent = motion.command[:, list(mechanism.driven)]
    header = ["time", *(f"{mechanism.actuator(i)}.command" for i in mechanism.driven)]
    table = np.hstack([run.ticks[:, None] * GRID * clock, sent])
    write_whole(folder / "commands.csv.gz", _csv(header, table), durable=False)
    true = ideal_readings(plant, motion.q, run.ticks, motion.step, joints)
    again = replayed(run, motion)
    nominal, oracle = (predict(each, again, here, rate) for each in (mechanism.plant, plant))
    error = truth.error
    errors = (prediction_error(nominal, true, error), prediction_error(oracle, true, error))
    return true, oracle, errors


def prediction_error(predicted: Array, true: Array, error: Array) -> float:
    """Return the RMS of predicted less true readings, in units of the readings' RMS error.

    Rows of no window are NaN in neither or in the prediction alone, and do not count.

    Args:
        predicted: Predicted readings, shape (rows, joints).
        true: Readings without noise, same shape.
        error: RMS error of each reading, shape (joints,).
    """
    known = np.isfinite(predicted).all(axis=1)
    return float(np.sqrt((((predicted - true)[known] / error) ** 2).mean()))


def _column(case: Case, channel: str) -> str:
    mechanism = case.mechanism
    part, _, quantity = channel.rpartition(".")
    joint = part.removesuffix("_drive")
    link, _, tracked = part.rpartition(".")
    if quantity == "time":
        unit = "s"
    elif link in mechanism.links:
        unit = "m" if tracked == "position" else "1"
    else:
        i = mechanism.joints.index(joint)
        slide, servo = mechanism.plant.slide[i], mechanism.plant.of_joint("drive")[i] == SERVO
        length = "m" if slide else "rad"
        effort = "N" if slide else "N m"
        unit = {"position": length, "velocity": f"{length}/s"}.get(
            quantity, length if servo else effort
        )
    return f'"{channel}" = {{ column = "{channel}", unit = "{unit}" }}'


def _lines(header: Sequence[str], table: Array) -> str:
    form = ",".join(["%.6f", *["%.8f"] * (table.shape[1] - 1)])
    return "\n".join([",".join(header), *(form % tuple(row) for row in table.tolist()), ""])


def _csv(header: Sequence[str], table: Array) -> bytes:
    return gzip.compress(_lines(header, table).encode(), compresslevel=6, mtime=0)


def _npz(arrays: dict[str, Array]) -> bytes:
    packed = io.BytesIO()
    # numpy writes the date 1980-01-01 into the archive: the bytes depend on the arrays alone.
    np.savez(packed, **arrays)  # type: ignore[arg-type]
    return packed.getvalue()
