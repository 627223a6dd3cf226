"""Poses that a recording tells of: joints by name, and bodies that were tracked."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.app.viewer.motion import RATE
from morph.arrays import Array
from morph.body.robot import Robot
from morph.record.quantities import pose_channels
from morph.record.recording import Recording


def untold(recording: Recording, robot: Robot) -> tuple[str, ...]:
    """Return the names of the joints of which a recording does not tell where they are."""
    return tuple(
        joint.name
        for joint in robot.joints
        if not set(pose_channels(joint)) <= set(recording.channels)
    )


def span(recording: Recording, robot: Robot) -> tuple[float, float]:
    """Return when all channels that tell a pose begin and end, s on the recording's clock."""
    tracks = [
        recording.channels[name]
        for joint in robot.joints
        for name in pose_channels(joint)
        if name in recording.channels
    ]
    return max(float(each.time[0]) for each in tracks), min(float(each.time[-1]) for each in tracks)


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
    result = np.repeat(np.asarray(model.qpos0)[None], len(when), axis=0)
    for joint in robot.joints:
        names = pose_channels(joint)
        if set(names) <= set(recording.channels):
            first = int(model.joint(joint.name).qposadr[0])
            for slot, name in enumerate(names):
                result[:, first + slot] = recording.channels[name].at(when)
            if joint.kind in {"free", "ball"}:
                turn = result[:, first + len(names) - 4 : first + len(names)]
                turn /= np.maximum(np.linalg.norm(turn, axis=1, keepdims=True), 1e-9)
    return result


def speeds(model: Any, positions: Array, picture: int) -> Array:
    """Return how fast a motion is in a picture, `qvel` of shape (nv,).

    It is the mean over two pictures to either side: encoders and cameras are noisy.
    """
    before, after = max(picture - 2, 0), min(picture + 2, len(positions) - 1)
    result: Array = np.zeros(model.nv)
    if after > before:
        seconds = (after - before) / RATE
        mujoco.mj_differentiatePos(model, result, seconds, positions[before], positions[after])
    return result
