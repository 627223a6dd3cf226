"""Poses that a recording tells of: joints by name, and bodies that were tracked."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.app.viewer.motion import RATE
from morph.arrays import Array
from morph.body.robot import Joint, Robot
from morph.record.quantities import WXYZ, XYZ
from morph.record.recording import Recording


def channels_of(joint: Joint) -> tuple[str, ...]:
    """Return the channels that tell where a joint is; none for a ball joint."""
    if joint.kind in {"hinge", "slide"}:
        return (f"{joint.name}.position",)
    if joint.kind == "free":
        places = tuple(f"{joint.link}.position.{axis}" for axis in XYZ)
        return places + tuple(f"{joint.link}.orientation.{axis}" for axis in WXYZ)
    return ()


def untold(recording: Recording, robot: Robot) -> tuple[str, ...]:
    """Return the names of the joints of which a recording does not tell where they are."""
    return tuple(
        joint.name
        for joint in robot.joints
        if not channels_of(joint) or not set(channels_of(joint)) <= set(recording.channels)
    )


def span(recording: Recording, robot: Robot) -> tuple[float, float]:
    """Return when all channels that tell a pose begin and end, s on the recording's clock."""
    told = [
        recording.channels[name]
        for joint in robot.joints
        for name in channels_of(joint)
        if name in recording.channels
    ]
    return max(float(each.time[0]) for each in told), min(float(each.time[-1]) for each in told)


def poses(recording: Recording, robot: Robot, model: Any, begin: float, seconds: float) -> Array:
    """Return poses in the pictures, `qpos` of shape (pictures, nq).

    What is not recorded is as the description has it.

    Args:
        recording: What was recorded.
        robot: Of which robot.
        model: Its `mujoco.MjModel`.
        begin: When the first picture is, s on the recording's clock.
        seconds: How long.
    """
    when = begin + np.arange(int(seconds * RATE + 1e-6) + 1) / RATE
    found = np.repeat(np.asarray(model.qpos0)[None], len(when), axis=0)
    for joint in robot.joints:
        names = channels_of(joint)
        if names and set(names) <= set(recording.channels):
            first = int(model.joint(joint.name).qposadr[0])
            for slot, name in enumerate(names):
                found[:, first + slot] = recording.channels[name].at(when)
            if joint.kind == "free":
                turn = found[:, first + 3 : first + 7]
                turn /= np.maximum(np.linalg.norm(turn, axis=1, keepdims=True), 1e-9)
    return found


def speeds(model: Any, positions: Array, picture: int) -> Array:
    """Return how fast a motion is in a picture, `qvel` of shape (nv,).

    It is the mean over two pictures to either side: encoders and cameras are noisy.
    """
    before, after = max(picture - 2, 0), min(picture + 2, len(positions) - 1)
    found: Array = np.zeros(model.nv)
    if after > before:
        seconds = (after - before) / RATE
        mujoco.mj_differentiatePos(model, found, seconds, positions[before], positions[after])
    return found
