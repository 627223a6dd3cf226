"""How a link that moves freely was turned, by the gyro and the accelerometer on it."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.record.quantities import WXYZ, XYZ
from morph.record.recording import Channel, Note, Recording

BEGIN = 0.2
"""Seconds whose mean acceleration tells which way is up as a recording begins."""
TILT_TIME, BIAS_TIME = 2.0, 20.0
"""Seconds in which errors of tilt fade, and in which a gyro's bias is learned."""
AT_REST = 0.2
"""Share of gravity by which a specific force may differ from it and still tell which way is up."""
LEAST = 0.1
"""m/s2: least gravity, and specific force as a recording begins, that tell which way is up."""
UNSURE = 0.01
"""rad: how far an orientation may be off, as white noise at the rate of readings."""


def with_imu_attitude(recording: Recording, robot: Robot) -> Recording:
    """Return a recording with orientations of free links that an inertial sensor on them tells.

    Rates are integrated, and what gravity says of tilt corrects them; heading begins at zero and
    drifts. It is noted. Links whose orientation was recorded stay as they are.

    Source: Mahony, Hamel and Pflimlin 2008, IEEE Transactions on Automatic Control 53(5),
    eq. 32 (the explicit complementary filter with bias).

    Args:
        recording: What was recorded: `<site>.gyro.{x,y,z}`, `<site>.accelerometer.{x,y,z}`, of a
            site or of a link that is fixed to the free one.
        robot: Its robot.
    """
    free = [joint.link for joint in robot.joints if joint.kind == "free"]
    unread = [link for link in free if f"{link}.orientation.w" not in recording.channels]
    if not unread:
        return recording
    model = spec_of(robot).compile()
    channels, notes = dict(recording.channels), []
    for link in unread:
        found = _sensor(model, recording, link)
        if found is None:
            continue
        site, turned = found
        # They tell nothing more then.
        gyro, felt = (
            [channels.pop(f"{site}.{quantity}.{axis}") for axis in XYZ]
            for quantity in ("gyro", "accelerometer")
        )
        time = gyro[0].time
        rates, forces = (
            np.stack([each.at(time) for each in parts], axis=1) @ turned.T for parts in (gyro, felt)
        )
        up = -np.asarray(model.opt.gravity)
        felt_first = forces[time < time[0] + BEGIN].mean(axis=0)
        if min(np.linalg.norm(up), np.linalg.norm(felt_first)) < LEAST:
            # Nothing tells which way is up.
            return recording
        attitude = integrated(time, rates, forces, up)
        for axis, value in zip(WXYZ, attitude.T, strict=True):
            # A rotation by a small angle changes a quaternion by half of it.
            channels[f"{link}.orientation.{axis}"] = Channel(
                time=time, value=value, noise=0.5 * UNSURE
            )
        notes.append(
            Note(
                what=f"how {link} was turned is told by {site}: its heading begins at 0 and drifts",
                where=f"recording {recording.name}",
            )
        )
    return replace(recording, channels=channels, notes=(*recording.notes, *notes))


def integrated(time: Array, rates: Array, forces: Array, up: Array) -> Array:
    """Return orientations, w first, by rates and specific forces in the body's axes.

    Args:
        time: Strictly increasing, s, shape (samples,).
        rates: rad/s, shape (samples, 3).
        forces: What an accelerometer reads, m/s2, shape (samples, 3).
        up: Gravity's opposite in the world, m/s2, shape (3,).
    """
    size = float(np.linalg.norm(up))
    begins = forces[time < time[0] + BEGIN].mean(axis=0)
    turn, bias = _shortest(begins, up), np.zeros(3)
    result = np.empty((len(time), 4))
    moved, shown = np.empty(4), np.empty(3)
    for at, step in enumerate(np.diff(time, append=time[-1:])):
        result[at] = turn
        mujoco.mju_negQuat(moved, turn)
        mujoco.mju_rotVecQuat(shown, up / size, moved)
        error = np.zeros(3)
        if size > 0.0 and abs(float(np.linalg.norm(forces[at])) - size) < AT_REST * size:
            error = np.cross(forces[at] / np.linalg.norm(forces[at]), shown)
        bias = bias - step / (TILT_TIME * BIAS_TIME) * error
        now = rates[at] if at + 1 == len(time) else 0.5 * (rates[at] + rates[at + 1])
        turn = np.array(turn)
        mujoco.mju_quatIntegrate(turn, now - bias + error / TILT_TIME, step)
    return result


def _sensor(model: mujoco.MjModel, recording: Recording, link: str) -> tuple[str, Array] | None:
    """Return a sensor fixed to a link that was recorded, and its axes as columns in the link's."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    weld = model.body_weldid[model.body(link).id]
    placed = {
        model.body(at).name: data.xmat[at]
        for at in range(model.nbody)
        if model.body_weldid[at] == weld
    }
    placed |= {
        model.site(at).name: data.site_xmat[at]
        for at in range(model.nsite)
        if model.body_weldid[model.site_bodyid[at]] == weld
    }
    base = placed[link].reshape(3, 3)
    for name, axes in placed.items():
        read = [f"{name}.{what}.{axis}" for what in ("gyro", "accelerometer") for axis in XYZ]
        if all(each in recording.channels for each in read):
            return name, base.T @ axes.reshape(3, 3)
    return None


def _shortest(along: Array, up: Array) -> Array:
    """Return the shortest rotation, w first, that takes one direction to another."""
    one, other = along / np.linalg.norm(along), up / np.linalg.norm(up)
    result = np.array([1.0 + one @ other, *np.cross(one, other)])
    if result[0] < 1e-9:
        # They are opposite: any axis across them will do.
        across = np.cross(one, np.eye(3)[int(np.abs(one).argmin())])
        result = np.array([0.0, *across])
    return np.asarray(result / np.linalg.norm(result))
