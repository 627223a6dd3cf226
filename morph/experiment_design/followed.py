"""Motions that a controller follows, for robots that their motors must hold up."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
from scipy.ndimage import uniform_filter1d

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import SimulationFailed
from morph.record.recording import Channel, Recording
from morph.sim.closed_loop import closed_loop
from morph.sim.simulator import Simulator, Trajectory

QUICKNESS = 12.0
"""Natural frequency of the controller, rad/s; it is critically damped."""
REACH, FREE = 0.45, 1.0
"""Share of a joint's range either way of its middle that the greatest motion reaches, and how far
one without a range goes, rad or m."""
BEGUN = 2.0
"""Seconds in which joints go from home to where they move about."""
SMOOTH = 0.2
"""Seconds over which corners of a motion are rounded."""
SATURATED = 0.02
"""Share of the samples in which a motor may be at its limit."""


def can_follow(robot: Robot) -> bool:
    """Return whether each of a robot's joints has a motor of its own, so that it goes anywhere."""
    motors = [each.joint for each in robot.actuators if each.kind == "motor"]
    joints = [joint.name for joint in robot.joints if joint.kind in ("hinge", "slide")]
    return len(joints) == len(robot.joints) and sorted(map(str, motors)) == sorted(joints)


def references(simulator: Simulator, time: Array, wave: Array) -> Array:
    """Return where joints are to be, rad or m, shape (samples, dofs).

    Args:
        simulator: The robot, at whose home they begin.
        time: Seconds, evenly spaced, shape (samples,).
        wave: Within -1 and 1, shape (samples, actuators).
    """
    model: Any = simulator.model
    home = model.qpos0.copy()
    limited = model.jnt_limited.astype(bool)
    low, high = np.where(limited, model.jnt_range.T, [home - FREE, home + FREE])
    middle = np.where(limited, 0.5 * (low + high), home)
    reach = np.where(limited, REACH * (high - low), FREE)
    share = np.clip(time / BEGUN, 0.0, 1.0)[:, None]
    gone = share**2 * (3.0 - 2.0 * share)
    dofs = [int(model.joint(each.joint).dofadr[0]) for each in simulator.robot.actuators]
    moved = np.empty((len(time), model.nv))
    moved[:, dofs] = wave
    path = home + gone * (middle - home) + gone * reach * moved
    width = max(1, round(SMOOTH / float(time[1] - time[0])))
    return np.asarray(uniform_filter1d(path, width, axis=0, mode="nearest"))


def follow(
    simulator: Simulator, time: Array, wanted: Array, low: Array, high: Array
) -> Recording | None:
    """Return the described robot under a controller, and what that commands; None if it cannot.

    The controller is computed torque: the description's inverse dynamics, with feedback.
    Source: Spong, Hutchinson and Vidyasagar 2006, Robot modeling and control, eq. 8.19.

    Args:
        simulator: The robot.
        time: Seconds, a step apart, shape (samples,).
        wanted: Where joints are to be, rad or m, shape (samples, dofs).
        low: The least command of each actuator, shape (actuators,).
        high: The greatest.
    """
    model: Any = simulator.model
    data = mujoco.MjData(model)
    speed = np.gradient(wanted, time, axis=0)
    pull = np.gradient(speed, time, axis=0)
    dofs = [int(model.joint(each.joint).dofadr[0]) for each in simulator.robot.actuators]
    unit = model.actuator_gear[:, 0] * model.actuator_gainprm[:, 0]
    if not unit.all():
        return None
    force, clipped = np.empty(model.nv), 0

    def act(position: Array, velocity: Array, now: float) -> Array:
        nonlocal clipped
        at = min(round(now / simulator.step), len(time) - 1)
        data.qpos[:], data.qvel[:] = position[0], velocity[0]
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        needed = pull[at] + QUICKNESS**2 * (wanted[at] - position[0])
        needed += 2.0 * QUICKNESS * (speed[at] - velocity[0])
        mujoco.mj_mulM(model, data, force, needed)
        command = (force + data.qfrc_bias - data.qfrc_passive)[dofs] / unit
        told = np.clip(command, low, high)
        clipped += int((told != command).any())
        return np.asarray(told[None])

    begun, still = wanted[:1].copy(), np.zeros((1, model.nv))
    try:
        runs = closed_loop(
            simulator, act, begun, still, period=simulator.step, seconds=float(time[-1])
        )
    except SimulationFailed:
        return None
    if not runs.stable[0] or clipped > SATURATED * len(time):
        return None
    moved = Trajectory(
        time=runs.time,
        position=runs.position[0],
        velocity=runs.velocity[0],
        command={
            each.name: runs.command[0, :-1, at] for at, each in enumerate(simulator.robot.actuators)
        },
    )
    return simulator.recorded(moved, "planned")


def reference_channels(robot: Robot, time: Array, wanted: Array) -> Iterator[tuple[str, Channel]]:
    """Yield where each joint is to be, by the name of its position's channel."""
    for at, joint in enumerate(robot.joints):
        yield f"{joint.name}.position", Channel(time=time, value=wanted[:, at])
