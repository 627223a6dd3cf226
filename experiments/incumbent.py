"""What `mujoco.sysid` fits to recordings, given what a careful user would give it."""

from __future__ import annotations

import contextlib
import importlib
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.openloop import Model, from_mjcf
from morph.arrays import Array
from morph.body.fulltext import fulltext
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.model.episodes import Episode
from morph.model.segments import Segments, cut

MASS_SHARE, COM_SHARE, INERTIA_FACTOR = 0.3, 0.3, 3.0
"""How far the description's figures may move, either way."""
MOST = {"armature": 0.02, "damping": 0.2, "frictionloss": 0.3}
"""The most that a joint may have, kg m2, N m s/rad and N m; the least is none."""
ITERATIONS = 200
"""The most that sysid takes by default."""


@dataclass(frozen=True, kw_only=True)
class Figure:
    """One figure that is fitted."""

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
    """Return mass, centre and inertia of every link; armature, damping and friction of joints."""
    spec = spec_of(robot)
    found = []
    for link in robot.links:
        com = np.array(link.com)
        reach = float(np.linalg.norm(com))
        across = float(max(link.inertia[:3]))
        spread = {
            "mass": (link.mass, 1.0 - MASS_SHARE, 1.0 + MASS_SHARE, _mass(link.name)),
            "com": (reach, 1.0 - COM_SHARE, 1.0 + COM_SHARE, _com(link.name, com / reach)),
            "inertia": (
                across,
                1 / INERTIA_FACTOR,
                INERTIA_FACTOR,
                _inertia(link.name, spec.body(link.name), across),
            ),
        }
        for what, (nominal, low, high, write) in spread.items():
            found.append(
                Figure(
                    name=f"{what}:{link.name}",
                    nominal=nominal,
                    low=low * nominal,
                    high=high * nominal,
                    write=write,
                )
            )
    for joint in robot.joints:
        for what, most in MOST.items():
            held = getattr(spec.joint(joint.name), what)
            found.append(
                Figure(
                    name=f"{what}:{joint.name}",
                    nominal=float(np.ravel(held)[0]),
                    low=0.0,
                    high=most,
                    write=_of_joint(joint.name, what),
                )
            )
    return found


def with_figures(robot: Robot, values: dict[str, float]) -> Robot:
    """Return the robot whose description states other figures; those not named stay."""
    spec = spec_of(robot)
    for figure in figures(robot):
        if figure.name in values:
            figure.write(spec, values[figure.name])
    spec.compile()
    return from_mjcf(fulltext(spec))


def by_sysid(
    robot: Robot,
    runs: Sequence[Episode],
    *,
    piece: float | None = None,
    iterations: int = ITERATIONS,
    fixed: Sequence[str] = (),
) -> tuple[Model, dict[str, float]]:
    """Return the model and the figures that `mujoco.sysid` fits with its own optimizer.

    It simulates the same description with the same solver and step as morph, from the
    same starts, under the same commands, against the same readings. What it prints as it
    works goes to the error stream.

    Args:
        robot: The nominal description.
        runs: Training runs.
        piece: Seconds of the rollouts that it fits; None for whole runs.
        iterations: The most that it may take.
        fixed: Kinds of figures that stay as described, as `frictionloss`.
    """
    sysid = _library()
    free = [each for each in figures(robot) if each.name.partition(":")[0] not in fixed]
    wanted = sysid.ParameterDict()
    for figure in free:
        wanted.add(
            sysid.Parameter(
                figure.name,
                figure.nominal,
                figure.low,
                figure.high,
                modifier=_modifier(figure),
            )
        )
        # Its own advice: what starts on a bound stalls there, as friction at zero does.
        wanted[figure.name].move_off_bound()
    measured = _sequences(robot, cut(runs, piece))
    with contextlib.redirect_stdout(sys.stderr):
        fitted, _ = sysid.optimize(
            wanted,
            sysid.build_residual_fn(models_sequences=[measured]),
            max_iters=iterations,
            x_scale="jac",
        )
    values = {figure.name: float(fitted[figure.name].value[0]) for figure in free}
    return Model(robot=with_figures(robot, values)), values


def _sequences(robot: Robot, segments: Segments) -> Any:
    """Return rollouts as sysid takes them, each on a clock of its own."""
    sysid, enums = _library(), importlib.import_module("mujoco")
    spec = spec_of(robot, timestep=segments.step)
    # It counts sensors even where states are compared; states, because its sensors lag a step.
    for joint in robot.joints:
        spec.add_sensor(
            name=f"{joint.name}_sensor",
            type=enums.mjtSensor.mjSENS_JOINTPOS,
            objtype=enums.mjtObj.mjOBJ_JOINT,
            objname=joint.name,
        )
    model = spec.compile()
    size = len(robot.joints)
    names = [f"{joint.name}_qpos" for joint in robot.joints]
    clock = segments.step * np.arange(segments.steps + 1)
    commands = segments.command([episode.command for episode in segments.episodes])
    starts, controls, readings = [], [], []
    for row in range(len(segments)):
        start, command = segments.start[row], commands[row]
        starts.append(sysid.create_initial_state(model, start[:size], start[size:]))
        # The last is never applied: a rollout has one state more than it has commands.
        held = np.concatenate([command, command[-1:]])
        controls.append(sysid.TimeSeries.from_control_names(clock, held, model))
        there = segments.valid[row].all(axis=1)
        when: Array = (segments.before[row] + segments.part[row])[there] * segments.step
        readings.append(
            sysid.TimeSeries.from_names(when, segments.reading[row][there], model, names)
        )
    titles = [f"rollout_{row}" for row in range(len(segments))]
    return sysid.ModelSequences(robot.name, spec, titles, starts, controls, readings)


def _library() -> Any:
    # An untyped library, and one that needs the packages of the extra `dev`.
    return importlib.import_module("mujoco.sysid")


def _modifier(figure: Figure) -> Callable[[Any, Any], None]:
    def write(spec: Any, parameter: Any) -> None:
        figure.write(spec, float(parameter.value[0]))

    return write


def _mass(link: str) -> Callable[[Any, float], None]:
    def write(spec: Any, value: float) -> None:
        spec.body(link).mass = value

    return write


def _com(link: str, direction: Array) -> Callable[[Any, float], None]:
    def write(spec: Any, value: float) -> None:
        spec.body(link).ipos = direction * value

    return write


def _inertia(link: str, body: Any, nominal: float) -> Callable[[Any, float], None]:
    # Always from the description's own: sysid writes into one spec over and over.
    principal, full = np.array(body.inertia), np.array(body.fullinertia)

    def write(spec: Any, value: float) -> None:
        spec.body(link).inertia = principal * (value / nominal)
        spec.body(link).fullinertia = full * (value / nominal)

    return write


def _of_joint(joint: str, what: str) -> Callable[[Any, float], None]:
    def write(spec: Any, value: float) -> None:
        # Damping is a polynomial of which the first coefficient is the linear one.
        held = np.array(getattr(spec.joint(joint), what), dtype=float)
        changed = np.ravel(held)
        changed[0] = value
        setattr(spec.joint(joint), what, changed if held.ndim else value)

    return write
