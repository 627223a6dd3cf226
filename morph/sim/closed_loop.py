"""Many simulations at once in a closed loop: what is told depends on what is seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError

from morph.arrays import Array, Mask
from morph.errors import SimulationFailed
from morph.physics.effect import Effect
from morph.physics.fluid.settle import batches
from morph.physics.stacked import stacked
from morph.sim.drive import received
from morph.sim.rollout import quiet
from morph.sim.rows import Rows
from morph.sim.simulator import Simulator
from morph.sim.threads import batch_threads

Act = Callable[[Array, Array, float], Array]
"""From `qpos` (rows, nq), `qvel` (rows, nv) and the time, s, to commands (rows, nu)."""


@dataclass(frozen=True, kw_only=True)
class ClosedLoopRuns:
    """States and commands of many simulations that ran in a closed loop."""

    time: Array
    """When, s, shape (samples,): the control times, or every step if that was asked for."""
    position: Array
    """MuJoCo's `qpos`, shape (rows, samples, nq)."""
    velocity: Array
    """MuJoCo's `qvel`, shape (rows, samples, nv)."""
    command: Array
    """What was told from each sample on, shape (rows, samples, nu); the last is held."""
    stable: Mask
    """Which rows stayed stable, shape (rows,); another repeats what MuJoCo reset it to."""


def closed_loop(
    simulator: Simulator,
    act: Act,
    position: Array,
    velocity: Array,
    *,
    period: float,
    seconds: float,
    every_step: bool = False,
) -> ClosedLoopRuns:
    """Return what many simulations do when each command depends on the state.

    Args:
        simulator: The body under its effects.
        act: What is told, asked once each control period for all rows.
        position: Where each row starts, shape (rows, nq).
        velocity: How fast, shape (rows, nv).
        period: How long each command is held, s, a multiple of the simulator's step.
        seconds: How long to run, a multiple of the period.
        every_step: Whether every step is a sample, not only the control times.

    Raises:
        SimulationFailed: The period is no multiple of the step, a command is no number,
            the fluid is not compiled, or MuJoCo refuses to step.
    """
    periods, steps = _counted(simulator, period, seconds)
    _check_fluid(simulator)
    model: Any = simulator.model
    rows = len(position)
    batch = Batch(model, rows, batch_threads(rows))
    batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE.value)
    q, v = batch.bind("qpos"), batch.bind("qvel")
    q[:], v[:] = position, velocity
    each = 1 if every_step else steps
    samples = periods * steps // each + 1
    qs, vs = np.empty((samples, rows, model.nq)), np.empty((samples, rows, model.nv))
    us = np.zeros((samples, rows, model.nu))
    arrives = _received(simulator, rows, periods * steps)
    advance = _advance(simulator, batch, each)
    qs[0], vs[0] = q, v
    with quiet():
        for at in range(samples - 1):
            now = at * each
            if now % steps == 0:
                command = _told(act, q, v, now * simulator.step, simulator)
                given = arrives(command, now, steps)
            us[at] = command
            advance(given[..., now % steps :][..., :each] if given.shape[-1] > 1 else given)
            qs[at + 1], vs[at + 1] = q, v
    us[-1] = us[-2]
    return ClosedLoopRuns(
        time=np.asarray(each * simulator.step * np.arange(samples), dtype=float),
        position=qs.swapaxes(0, 1),
        velocity=vs.swapaxes(0, 1),
        command=us.swapaxes(0, 1),
        stable=~batch.warning[..., 1].any(axis=1),
    )


def _counted(simulator: Simulator, period: float, seconds: float) -> tuple[int, int]:
    steps = round(period / simulator.step)
    periods = round(seconds / period) if period > 0.0 else 0
    if steps < 1 or abs(steps * simulator.step - period) > 1e-6 * period or periods < 1:
        raise SimulationFailed(
            f"a control period of {period:g} s fits neither steps of {simulator.step:g} s "
            f"nor a run of {seconds:g} s",
            where=f"robot {simulator.robot.name}",
            fix="give a step that divides the period, and a run of one period or more",
        )
    simulator.steps(seconds)
    return periods, steps


def _check_fluid(simulator: Simulator) -> None:
    if not batches(simulator.model):
        raise SimulationFailed(
            "a closed loop needs the compiled fluid",
            where=f"robot {simulator.robot.name} in a fluid, which runs in numpy here",
            fix="install a C compiler, or `pip install ziglang`, which brings one",
        )


def _received(simulator: Simulator, rows: int, steps: int) -> Callable[[Array, int, int], Array]:
    """Return what tells the commands that arrive at each step of a control period.

    It takes what is told (rows, nu), the first step and how many there are, and gives
    (rows, nu, steps), or (rows, nu, 1) if nothing changes commands on their way.
    """
    if not any(type(effect).command is not Effect.command for effect in simulator.effects):
        return lambda command, first, count: command[..., None]
    history = np.empty((rows, simulator.model.nu, steps))

    def filtered(command: Array, first: int, count: int) -> Array:
        # Delays and lags look back: all that was told so far goes through them again.
        history[..., first : first + count] = command[..., None]
        given = np.empty((rows, simulator.model.nu, count))
        for actuator in simulator.robot.actuators:
            index = simulator.model.actuator(actuator.name).id
            whole = history[:, index, : first + count]
            given[:, index] = received(simulator.effects, actuator.name, whole, simulator.step)[
                ..., first:
            ]
        return given

    return filtered


def _advance(simulator: Simulator, batch: Batch, each: int) -> Callable[[Array], None]:
    """Return what steps every row `each` times, effects that act before each step included.

    It takes the commands of these steps, (rows, nu, each), or (rows, nu, 1) for all of them.
    """
    rows = Rows(batch, simulator.step)
    control = batch.bind("ctrl")
    acting = [stacked([effect] * batch.nsim) for effect in simulator.effects if effect.stepped]
    states = [effect.initial_state(rows) for effect in acting]

    def step(given: Array) -> None:
        try:
            if not acting and given.shape[-1] == 1:
                control[:] = given[..., 0]
                batch.step(nstep=each)
                return
            for at in range(each):
                control[:] = given[..., min(at, given.shape[-1] - 1)]
                rows.act(acting, states)
                batch.step()
        except SimulationError as error:
            raise SimulationFailed(
                f"MuJoCo stopped: {error}",
                where=f"a closed loop of {batch.nsim} simulations of {simulator.robot.name}",
                fix="check the robot's masses and inertias, or take a smaller step",
            ) from error

    return step


def _told(act: Act, q: Array, v: Array, time: float, simulator: Simulator) -> Array:
    command = np.asarray(act(q, v, time), dtype=float)
    if command.shape != (len(q), simulator.model.nu) or not np.isfinite(command).all():
        raise SimulationFailed(
            f"its command at {time:.3g} s is not a finite number for each of "
            f"{simulator.model.nu} actuators in each of {len(q)} runs",
            where=f"robot {simulator.robot.name}",
            fix="give commands of shape (rows, actuators)",
        )
    return command
