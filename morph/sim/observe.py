"""What a recording holds of a motion: joints, floating bodies, the description's sensors."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.fluid.kernel import flowing
from morph.physics.fluid.reference import wet_bodies
from morph.record.quantities import WXYZ, XYZ
from morph.record.recording import Channel

FELT = ("gyro", "accelerometer", "force")
"""Kinds of sensors that a recording has channels for, named by their site."""


def observed(
    robot: Robot, model: Any, times: Array, position: Array, velocity: Array
) -> dict[str, Channel]:
    """Return the channels that specs of recordings name, all but the commands.

    Of a body in a fluid the force sensors are left out: MuJoCo's know no fluid.

    Args:
        robot: The robot.
        model: The `mujoco.MjModel` that moved.
        times: When, s, evenly spaced, shape (samples,).
        position: MuJoCo's `qpos` then, shape (samples, nq).
        velocity: MuJoCo's `qvel` then, shape (samples, nv).
    """
    channels: dict[str, Channel] = {}
    for joint in robot.joints:
        here = model.joint(joint.name)
        q, v = int(here.qposadr[0]), int(here.dofadr[0])
        if joint.kind in {"hinge", "slide"}:
            results = {"position": position[:, q], "velocity": velocity[:, v]}
            channels |= _named(joint.name, results, times)
        elif joint.kind == "free":
            channels |= _named(joint.link, dict(_floating(position, velocity, q, v)), times)
        else:
            channels |= _named(joint.name, dict(_turning(position, velocity, q, v)), times)
    return channels | _sensors(robot, model, times, position, velocity)


def _named(part: str, results: dict[str, Array], times: Array) -> dict[str, Channel]:
    return {f"{part}.{name}": Channel(time=times, value=value) for name, value in results.items()}


def _floating(position: Array, velocity: Array, q: int, v: int) -> Iterator[tuple[str, Array]]:
    """Yield what is known of a free joint: MuJoCo keeps it in the very frames of a recording."""
    for at, axis in enumerate(XYZ):
        yield f"position.{axis}", position[:, q + at]
    for at, axis in enumerate(XYZ):
        yield f"linear_velocity.{axis}", velocity[:, v + at]
    yield from _turning(position, velocity, q + 3, v + 3)


def _turning(position: Array, velocity: Array, q: int, v: int) -> Iterator[tuple[str, Array]]:
    """Yield what is known of a rotation."""
    for at, axis in enumerate(WXYZ):
        yield f"orientation.{axis}", position[:, q + at]
    for at, axis in enumerate(XYZ):
        yield f"angular_velocity.{axis}", velocity[:, v + at]


def _sensors(
    robot: Robot, model: Any, times: Array, position: Array, velocity: Array
) -> dict[str, Channel]:
    # MuJoCo tells a force between two links without the fluid's on either: no channel is better
    # than a neutrally buoyant link that hangs from its joint by all its weight.
    kinds = FELT if not len(wet_bodies(model)) else tuple(kind for kind in FELT if kind != "force")
    # A description's sensors come first, in its order; an effect adds its own behind them.
    felt = [(at, one) for at, one in enumerate(robot.sensors) if one.kind in kinds and one.part]
    if not felt or len(times) < 2:
        return {}
    data = _readings(model, times, position, velocity)
    channels: dict[str, Channel] = {}
    for index, sensor in felt:
        first = int(model.sensor_adr[index])
        # A gyro reads the state; the others read what happens in the step that follows it.
        last = len(times) if sensor.kind == "gyro" else len(times) - 1
        for at, axis in enumerate(XYZ):
            channels.setdefault(
                f"{sensor.part}.{sensor.kind}.{axis}",
                Channel(time=times[:last], value=data[:last, first + at]),
            )
    return channels


def _readings(model: Any, times: Array, position: Array, velocity: Array) -> Array:
    """Return MuJoCo's `sensordata` along a motion, shape (samples, sensors).

    By inverse dynamics from the acceleration that each step really had, (v' - v) / h:
    so whatever drove the motion, fluid, contacts, effects, is in what is felt.
    """
    model = copy(model)
    if model.opt.integrator != mujoco.mjtIntegrator.mjINT_RK4:
        # The integrators but that one change the acceleration; so does this, back.
        model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_INVDISCRETE)
    data = mujoco.MjData(model)
    acceleration = np.diff(velocity, axis=0) / np.diff(times)[:, None]
    acceleration = np.concatenate([acceleration, acceleration[-1:]])
    result = np.empty((len(times), model.nsensordata))
    with flowing(model):
        for at in range(len(times)):
            data.qpos, data.qvel, data.qacc = position[at], velocity[at], acceleration[at]
            mujoco.mj_inverse(model, data)
            result[at] = data.sensordata
    return result
