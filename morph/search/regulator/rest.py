"""Where a body can rest as its task asks, and the command that holds it there."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from scipy.optimize import least_squares

from morph.arrays import Array
from morph.errors import SearchError
from morph.search.trajectory.plant import Plant
from morph.search.trajectory.tangent import apart, moved_by
from morph.sim.start import started
from morph.task.moved import Moved
from morph.task.task import Task

STARTS = 6
"""Postures from which a state of rest is looked for."""

UNHELD = 1e-3
"""Force that no actuator holds, as a share of the body's weight, N or N m, at most."""

UNIT = 1e-3
"""Command at which an actuator's force is read off, in its unit."""

ROUNDING = 1e-4
"""Share of a command's range by which what holds may lie beyond it."""

NEAR = 1e-3
"""Pull towards the first posture, for joints that nothing else determines."""


@dataclass(frozen=True, kw_only=True)
class Rest:
    """A state in which a body stays under a constant command."""

    position: Array
    """MuJoCo's `qpos`, shape (nq,)."""
    velocity: Array
    """Zeros, shape (nv,)."""
    command: Array
    """What holds it, shape (nu,)."""


def rest(task: Task, plant: Plant, rng: np.random.Generator) -> Rest:
    """Return where the body rests so that every goal of a task is met as well as can be.

    Errors of the goals, in shares of what they allow, and forces that no actuator holds are made
    least together, from the task's start and from postures drawn about it.

    Raises:
        SearchError: Where it meets its goals it does not rest, or the bounds of the commands
            do not let it.
    """
    model = plant.model
    first, _ = started(plant.robot, model, task.start.position, task.start.speed)
    free = unlimited(model)
    data = mujoco.MjData(free)
    weight = float(np.sum(model.body_mass) * np.linalg.norm(model.opt.gravity)) or 1.0

    def residual(move: Array) -> Array:
        q = moved_by(model, first, move)
        _, unheld = holding(free, data, q)
        return np.concatenate([_goals(task, model, q), 100.0 * unheld / weight, NEAR * move])

    def astray(move: Array) -> Array:
        return np.concatenate([_goals(task, model, moved_by(model, first, move)), NEAR * move])

    best: Any = None
    for each in range(STARTS):
        if each == 1:
            # Where it hangs, forces of a long link may outweigh its goals: these alone first.
            begin = least_squares(astray, np.zeros(model.nv)).x
        else:
            begin = rng.normal(0.0, 1.0, model.nv) if each else np.zeros(model.nv)
        result = least_squares(residual, begin, xtol=1e-12, ftol=1e-12, gtol=1e-12)
        if best is None or result.cost < best.cost - 1e-6:
            best = result
        if best.cost < 1e-3 * max(model.nv, 1):
            break
    q = moved_by(model, first, best.x)
    command, unheld = holding(free, data, q)
    where = f"task {task.name} of {plant.robot.name}"
    if np.abs(unheld).max(initial=0.0) > UNHELD * weight:
        joint = _joint(model, int(np.argmax(np.abs(unheld))))
        raise SearchError(
            f"where its goals are met it does not rest: {np.abs(unheld).max():.3g} N or N m "
            f"at {joint} that no actuator holds",
            where=where,
            fix="give goals at which the body can stand still, or a search that needs no rest",
        )
    beyond = np.maximum(plant.low - command, command - plant.high)
    # A servo may have to hold a joint at the very end of its range, and rounding is no lack.
    if (beyond > ROUNDING * (plant.high - plant.low)).any():
        at = int(np.argmax(beyond))
        raise SearchError(
            f"to rest there needs {command[at]:.3g} of actuator {model.actuator(at).name!r}, "
            f"whose bounds are {plant.low[at]:.3g} and {plant.high[at]:.3g}",
            where=where,
            fix="give a stronger actuator, or other goals",
        )
    return Rest(
        position=q, velocity=np.zeros(model.nv), command=np.clip(command, plant.low, plant.high)
    )


def unlimited(model: Any) -> Any:
    """Return the model with actuators that nothing clamps, so that they answer linearly."""
    free = copy.copy(model)
    free.actuator_forcelimited[:] = 0
    free.actuator_ctrllimited[:] = 0
    free.jnt_actfrclimited[:] = 0
    return free


def holding(model: Any, data: Any, position: Array) -> tuple[Array, Array]:
    """Return the command that best holds a posture, (nu,), and the force it leaves, (nv,)."""
    return driven(model, data, position, np.zeros(model.nv), np.zeros(model.nv))


def driven(
    model: Any, data: Any, position: Array, velocity: Array, acceleration: Array
) -> tuple[Array, Array]:
    """Return the command that best gives an acceleration, (nu,), and the force it leaves, (nv,).

    The force comes of inverse dynamics. What the actuators give is affine in the command: it is
    read off at zero and at a little of each.

    Args:
        model: A model that `unlimited` gave.
        data: Its `mujoco.MjData`.
        position: MuJoCo's `qpos`, shape (nq,).
        velocity: Shape (nv,).
        acceleration: Shape (nv,).
    """
    data.qpos[:], data.qvel[:], data.qacc[:] = position, velocity, acceleration
    data.ctrl[:] = 0.0
    mujoco.mj_inverse(model, data)
    wanted = data.qfrc_inverse.copy()
    mujoco.mj_fwdActuation(model, data)
    zero = data.qfrc_actuator.copy()
    moment = np.empty((model.nv, model.nu))
    for at in range(model.nu):
        data.ctrl[:] = 0.0
        data.ctrl[at] = UNIT
        mujoco.mj_fwdActuation(model, data)
        moment[:, at] = (data.qfrc_actuator - zero) / UNIT
    command, *_ = np.linalg.lstsq(moment, wanted - zero, rcond=None)
    return command, wanted - zero - moment @ command


def _goals(task: Task, model: Any, position: Array) -> Array:
    """Return the errors of every goal in shares of what it allows, and of the terms' targets."""
    moved = Moved(
        robot=task.robot,
        model=model,
        time=np.zeros(1),
        position=position[None, None],
        velocity=np.zeros((1, 1, model.nv)),
        command=np.zeros((1, 1, model.nu)),
    )
    errors = [
        goal.quantity.error(moved, goal.target)[0, 0] / goal.within
        for goal in task.goals
        if np.isfinite(goal.within)
    ]
    return np.concatenate(errors) if errors else np.zeros(0)


def _joint(model: Any, dof: int) -> str:
    return str(model.joint(int(model.dof_jntid[dof])).name)


def off_rest(plant: Plant, still: Rest, q: Array, v: Array) -> Array:
    """Return how far states are from rest, hinges the shorter way round, shape (..., 2 nv)."""
    place = apart(plant.model, q, still.position, wrapped=True)
    return np.concatenate(np.broadcast_arrays(place, v - still.velocity), axis=-1)
