"""The incumbent, mujoco.sysid, beside morph.diagnose on the same recordings of one rig."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from experiments.data import DataError, data_root
from experiments.openloop import (
    Model,
    bound,
    corrected,
    errors,
    from_mjcf,
    in_row,
    laid,
    named,
    span,
)
from morph.arrays import JSON
from morph.body.fulltext import fulltext
from morph.body.load import load as load_robot
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import MorphError
from morph.model.diagnose import diagnose
from morph.model.episodes import Episode
from morph.model.split import between
from morph.record.recording import Recording

EXAMPLE = """example:
  python -m experiments.bench_diagnose
  python -m experiments.bench_diagnose --quick --json
"""
FOLDER, BINDING, ROBOT = "dfki_double_pendulum", "dfki_c0", "double_pendulum"
TRAIN = ("run_00", "run_01", "run_02", "run_04")
HELD_OUT = ("run_03", "run_05", "run_06")
HORIZONS = (None, 1.0)
MASS_SHARE, COM_SHARE, INERTIA_FACTOR = 0.3, 0.3, 3.0
"""How far sysid may move the description's figures: as a careful user would allow."""
LOSS = {"armature": 0.02, "damping": 0.2, "frictionloss": 0.3}
"""The most that sysid may give a joint; the least is none."""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """One figure that sysid may change."""

    name: str
    """As `mass:upper`."""
    nominal: float
    """What the description says."""
    low: float
    """The least it may become."""
    high: float
    """The most."""
    write: Callable[[Any, float], None]
    """Puts a value into a `mujoco.MjSpec`."""


def figures(robot: Robot) -> list[Figure]:
    """Return the figures that a user of sysid would name: six a link with its joint."""
    found = []
    for link in robot.links:
        reach = float(np.linalg.norm(link.com))
        across = link.inertia[1]
        found += [
            Figure(
                name=f"mass:{link.name}",
                nominal=link.mass,
                low=(1 - MASS_SHARE) * link.mass,
                high=(1 + MASS_SHARE) * link.mass,
                write=lambda spec, value, part=link.name: setattr(spec.body(part), "mass", value),
            ),
            Figure(
                name=f"com:{link.name}",
                nominal=reach,
                low=(1 - COM_SHARE) * reach,
                high=(1 + COM_SHARE) * reach,
                write=lambda spec, value, part=link.name, along=np.array(link.com) / reach: setattr(
                    spec.body(part), "ipos", along * value
                ),
            ),
            Figure(
                name=f"inertia:{link.name}",
                nominal=across,
                low=across / INERTIA_FACTOR,
                high=across * INERTIA_FACTOR,
                write=lambda spec, value, part=link.name, nominal=across: _scale(
                    spec.body(part), value / nominal
                ),
            ),
        ]
    for joint in robot.joints:
        for what, most in LOSS.items():
            nominal = float(np.ravel(getattr(spec_of(robot).joint(joint.name), what))[0])
            found.append(
                Figure(
                    name=f"{what}:{joint.name}",
                    nominal=nominal,
                    low=0.0,
                    high=most,
                    write=lambda spec, value, part=joint.name, what=what: _put(
                        spec.joint(part), what, value
                    ),
                )
            )
    return found


def _scale(body: Any, factor: float) -> None:
    body.inertia = body.inertia * factor
    body.fullinertia = body.fullinertia * factor


def _put(joint: Any, what: str, value: float) -> None:
    held = getattr(joint, what)
    if np.ndim(held):
        changed = np.array(held)
        changed[0] = value
        setattr(joint, what, changed)
    else:
        setattr(joint, what, value)


def by_sysid(
    robot: Robot, runs: Sequence[Episode], *, piece: float | None, iterations: int
) -> tuple[Model, dict[str, float]]:
    """Return the model and the figures that `mujoco.sysid` fits, its settings its own.

    It simulates the same spec with the same step as morph does, and is given the same
    states to start from, so that the score of neither favours its maker.

    Args:
        robot: The nominal description.
        runs: Training runs.
        piece: Seconds of each rollout that is fitted; None for whole runs.
        iterations: The most it may take.
    """
    from mujoco import sysid

    spec = spec_of(robot, timestep=runs[0].step)
    for joint in robot.joints:
        spec.add_sensor(
            name=f"{joint.name}_position",
            type=_position_sensor(),
            objtype=_joint_object(),
            objname=joint.name,
        )
    names, starts, controls, sensed = [], [], [], []
    model = spec.compile()
    for run in runs:
        for number, (start, end) in enumerate(_pieces(run, piece)):
            state = [np.interp(start, run.time, column) for column in run.state.T]
            half = len(state) // 2
            names.append(f"{run.name}_{number}")
            starts.append(
                sysid.create_initial_state(model, np.array(state[:half]), np.array(state[half:]))
            )
            controls.append(_series(sysid, run, robot, "command", start, end))
            sensed.append(_series(sysid, run, robot, "position", start, end))
    free = figures(robot)
    wanted = sysid.ParameterDict()
    for figure in free:
        wanted.add(
            sysid.Parameter(
                figure.name,
                figure.nominal,
                figure.low,
                figure.high,
                modifier=lambda spec, parameter, write=figure.write: write(
                    spec, float(parameter.value[0])
                ),
            )
        )
        # What starts on its bound stalls there: its own advice.
        wanted[figure.name].move_off_bound()
    sequences = sysid.ModelSequences(robot.name, spec, names, starts, controls, sensed)
    fitted, _ = sysid.optimize(
        wanted,
        sysid.build_residual_fn(models_sequences=[sequences]),
        verbose=False,
        max_iters=iterations,
        x_scale="jac",
    )
    values = {figure.name: float(fitted[figure.name].value[0]) for figure in free}
    plain = spec_of(robot)
    for figure in free:
        figure.write(plain, values[figure.name])
    plain.compile()
    return Model(robot=from_mjcf(fulltext(plain))), values
