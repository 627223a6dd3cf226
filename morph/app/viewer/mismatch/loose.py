"""A window of any robot, simulated from what it has: bodies that float, joints not measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from morph.app.viewer.mismatch.poses import speeds
from morph.app.viewer.mismatch.window import MismatchModel, MismatchTrace
from morph.app.viewer.motion import RATE
from morph.arrays import Array
from morph.body.robot import Joint, Robot
from morph.errors import SimulationFailed
from morph.record.noise import noise
from morph.record.quantities import pose_channels
from morph.record.recording import Recording
from morph.sim.simulator import Simulator
from morph.sim.start import PLACES, SPEEDS

STEP = 0.002
"""Seconds a step."""


def simulated(
    model: MismatchModel,
    recording: Recording,
    measured: Array,
    begin: float,
    horizon: float | None,
) -> tuple[Array, str | None]:
    """Return poses by simulation in the pictures, and why it stopped short, if it did.

    Every rollout starts where the recording is, as fast as it moves there, and gets the
    recorded commands. After a rollout that failed the poses are those of the recording.

    Args:
        model: What is simulated.
        recording: What was recorded, with a command for every actuator.
        measured: Recorded poses in the pictures, (pictures, nq).
        begin: When the first picture is, s on the recording's clock.
        horizon: Seconds a rollout; None for one from start to end.
    """
    simulator = Simulator(model.robot, model.effects, step=STEP)
    result, why = measured.copy(), None
    each = len(measured) - 1 if horizon is None else max(1, round(horizon * RATE))
    for first in range(0, len(measured) - 1, each):
        last = min(first + each, len(measured) - 1)
        try:
            moved = simulator.trajectory(
                seconds=(last - first) / RATE,
                command=_commands(model.robot, recording, begin + first / RATE),
                **_start(model.robot, simulator.model, recording, measured, first, begin),
            )
        except SimulationFailed as error:
            why = f"{first / RATE:.3g} s into the window: {error.what}"
            continue
        when = np.arange(last - first + 1) / RATE
        # Between steps of 2 ms a quaternion turns too little for its length to change.
        result[first : last + 1] = np.stack(
            [np.interp(when, moved.time, column) for column in moved.position.T], axis=1
        )
    return result, why


def traced(
    robot: Robot,
    model: Any,
    recording: Recording,
    measured: Array,
    poses: Mapping[str, Array],
) -> tuple[MismatchTrace, ...]:
    """Return each recorded channel of a pose along the pictures."""
    when = np.arange(len(measured)) / RATE
    results = []
    for joint in robot.joints:
        first = int(model.joint(joint.name).qposadr[0])
        for slot, name in enumerate(pose_channels(joint)):
            if name not in recording.channels:
                continue
            values = {key: each[:, first + slot] for key, each in poses.items()}
            read = measured[:, first + slot]
            error = {key: np.sqrt(np.mean((each - read) ** 2)) for key, each in values.items()}
            channel = recording.channels[name]
            results.append(
                MismatchTrace(
                    channel=name,
                    unit=_unit(joint, slot),
                    link=joint.link,
                    time=when,
                    measured=read,
                    simulated=values,
                    noise=max(noise(channel.time, channel.value), 1e-5),
                    rmse={key: float(each) for key, each in error.items()},
                )
            )
    return tuple(results)


def _unit(joint: Joint, slot: int) -> str:
    if joint.kind in {"hinge", "slide"}:
        return joint.unit
    return "m" if joint.kind == "free" and slot < 3 else "-"


def _commands(robot: Robot, recording: Recording, begin: float) -> dict[str, Any]:
    return {
        actuator.name: lambda t, at=recording.channels[f"{actuator.name}.command"].at: at(begin + t)
        for actuator in robot.actuators
    }


def _start(
    robot: Robot, model: Any, recording: Recording, measured: Array, picture: int, begin: float
) -> dict[str, Any]:
    """Return what `Simulator.trajectory` is told of a start: joints and bodies by their names.

    Speeds that were not recorded are read off the poses about it.
    """
    position, velocity = measured[picture], speeds(model, measured, picture)
    start: dict[str, float] = {}
    speed: dict[str, float] = {}
    for joint in robot.joints:
        here = model.joint(joint.name)
        q, v = int(here.qposadr[0]), int(here.dofadr[0])
        if joint.kind in {"hinge", "slide"}:
            start[joint.name], speed[joint.name] = float(position[q]), float(velocity[v])
        elif joint.kind == "free":
            start |= _named(joint.link, PLACES, position[q : q + 7])
            speed |= _named(joint.link, SPEEDS, velocity[v : v + 6])
        else:
            start |= _named(joint.name, PLACES[3:], position[q : q + 4])
            speed |= _named(joint.name, SPEEDS[3:], velocity[v : v + 3])
    for name in speed:
        channel = recording.channels.get(name, recording.channels.get(f"{name}.velocity"))
        if channel is not None:
            speed[name] = float(channel.at(np.array(begin + picture / RATE)))
    return {"start": start, "speed": speed}


def _named(link: str, names: Sequence[str], values: Array) -> dict[str, float]:
    return {f"{link}.{name}": float(value) for name, value in zip(names, values, strict=True)}
