"""Where models lead each recorded state in one control period: what they get wrong, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.model.latent.run import Run
from morph.policy.observing import addresses
from morph.sim.drive import received, unsensed
from morph.sim.rollout import Variant, rollout
from morph.sim.tangent import apart, moved_by

NUDGE = 1e-5
"""Step of finite differences in states, in the units of `qvel`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ModelTransitions:
    """One run through several models, one control period at a time.

    With a state x, its observation y and the error delta = x - y, to first order

        delta(t+1) = miss(t) + doubt(t) theta + carry(t) delta(t),

    which is why neighbouring misses are correlated even if the model is right. theta says how
    far figures in doubt are off, by their standard deviations. Differences of states are moves
    in the coordinates of `qvel`, so bodies may float.
    """

    period: float
    """Control period, s."""
    miss: Array
    """Where each model leads less what was observed there, shape (models, periods, 2 nv)."""
    change: Array
    """Change of the velocity that each model tells, shape (models, periods, nv)."""
    carry: Array
    """What becomes of a small error of the state, shape (models or 1, periods, 2 nv, 2 nv)."""
    doubt: Array
    """What doubtful figures change, shape (models, periods, 2 nv, doubts)."""


def transitions(
    robot: Robot,
    variants: Sequence[Variant],
    run: Run,
    *,
    doubts: Sequence[Sequence[Variant]] = (),
    each: bool = True,
    carry: Array | None = None,
) -> ModelTransitions:
    """Return a run's transitions under several models, all in one batch.

    Args:
        robot: The body.
        variants: Models of it, of the same sizes and step.
        run: What was recorded.
        doubts: For each model itself with one doubtful figure moved by a standard deviation, for
            each such figure; as many for all models. If not given, no figure is in doubt.
        each: Whether the carry is told by each model, or by the first for all: it only says how
            noise is handed on, and costs 2 nv rows a period.
        carry: If it is known already, and not to be told again.

    Raises:
        DiagnosisError: The run is not of this body, or its period is no multiple of the step.
    """
    model: Any = variants[0].model
    substeps = _fits(robot, model, run)
    nv, periods, models = model.nv, len(run.command), len(variants)
    doubted = len(doubts[0]) if doubts else 0
    every = [*variants, *(variant for of_model in doubts for variant in of_model)]
    seen = [_unsensed(robot, variant, run) for variant in every]
    carrying = range(0 if carry is not None else models if each else 1)
    rows = [(k, *seen[k]) for k in range(len(every))]
    for k in carrying:
        rows += [(k, *_nudged(model, *seen[k], dof)) for dof in range(2 * nv)]
    q_end, v_end = _ends(robot, every, run, substeps, rows)
    miss = np.empty((len(every), periods, 2 * nv))
    for k, (position, velocity) in enumerate(seen):
        miss[k, :, :nv] = apart(model, q_end[k], position[1:], wrapped=True)
        miss[k, :, nv:] = v_end[k] - velocity[1:]
    if carry is None:
        # Rows are nudges and columns what they move: turned about here.
        ends = zip(_nudges(q_end, len(every), nv), _nudges(v_end, len(every), nv), strict=True)
        carry = np.stack(
            [
                np.moveaxis(
                    np.concatenate(
                        [apart(model, q, q_end[k], wrapped=True), v - v_end[k]], axis=-1
                    ),
                    0,
                    -1,
                )
                / NUDGE
                for k, (q, v) in enumerate(ends)
            ]
        )
    changed = miss[models:].reshape(models, doubted, periods, 2 * nv) - miss[:models, None]
    return ModelTransitions(
        period=run.period,
        miss=miss[:models],
        change=v_end[:models] - np.stack([velocity[:-1] for _, velocity in seen[:models]]),
        carry=carry,
        doubt=np.moveaxis(changed, 1, -1),
    )


def _nudges(end: Array, first: int, nv: int) -> Array:
    """Return where nudged rows lead, shape (models, 2 nv, periods, ...)."""
    return end[first:].reshape(-1, 2 * nv, *end.shape[1:])


def _ends(
    robot: Robot,
    variants: Sequence[Variant],
    run: Run,
    substeps: int,
    rows: Sequence[tuple[int, Array, Array]],
) -> tuple[Array, Array]:
    """Return where rows of a variant and its states lead: (rows, periods, nq) and (..., nv)."""
    received = [_received(robot, variant, run, substeps) for variant in variants]
    periods = len(run.command)
    q, v = rollout(
        variants,
        np.repeat([k for k, _, _ in rows], periods),
        np.concatenate([position[:-1] for _, position, _ in rows]),
        np.concatenate([velocity[:-1] for _, _, velocity in rows]),
        np.concatenate([received[k] for k, _, _ in rows]),
    )
    return tuple(end[:, -1].reshape(len(rows), periods, -1) for end in (q, v))  # type: ignore[return-value]


def _fits(robot: Robot, model: Any, run: Run) -> int:
    """Return how many steps a control period has, and check the run's shapes."""
    shapes = (run.position.shape[1], run.velocity.shape[1], run.command.shape[1])
    if shapes != (model.nq, model.nv, model.nu):
        raise DiagnosisError(
            f"it has {shapes[0]} positions, {shapes[1]} velocities and {shapes[2]} commands; "
            f"the body has {model.nq}, {model.nv} and {model.nu}",
            where=f"a run of robot {robot.name}",
            fix="give states and commands in the order of the body's joints and actuators",
        )
    ratio = float(run.period / model.opt.timestep)
    if ratio < 0.5 or abs(ratio - round(ratio)) > 1e-6:
        raise DiagnosisError(
            f"a control period of {run.period:g} s is no multiple of a step, "
            f"{model.opt.timestep:g} s",
            where=f"a run of robot {robot.name}",
            fix="give models a step that divides the period",
        )
    return round(ratio)


def _unsensed(robot: Robot, variant: Variant, run: Run) -> tuple[Array, Array]:
    """Return positions and velocities as a model's sensors would have them without its biases."""
    if not any(effect.kind == "sensor" for effect in variant.effects):
        return run.position, run.velocity
    state, nq = run.state.copy(), run.position.shape[1]
    for channel, at in addresses(robot, variant.model).items():
        state[:, at] = unsensed(variant.effects, channel, state[:, at])
    return state[:, :nq], state[:, nq:]


def _received(robot: Robot, variant: Variant, run: Run, substeps: int) -> Array:
    """Return what actuators receive in each step of each period, (periods, substeps, nu)."""
    given = np.repeat(run.command, substeps, axis=0)
    for actuator in robot.actuators:
        at = variant.model.actuator(actuator.name).id
        # Delays and lags look back: they see the whole run, not one period.
        given[:, at] = received(variant.effects, actuator.name, given[:, at], run.period / substeps)
    return given.reshape(len(run.command), substeps, -1)


def _nudged(model: Any, position: Array, velocity: Array, dof: int) -> tuple[Array, Array]:
    """Return states with one coordinate moved a little: first those of the position."""
    step = np.zeros(model.nv)
    step[dof % model.nv] = NUDGE
    if dof < model.nv:
        return moved_by(model, position, step), velocity
    return position, velocity + step
