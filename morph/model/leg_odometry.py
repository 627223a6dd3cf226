"""Where a link that moves freely was, by its feet on the floor."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.model.imu_attitude import with_imu_attitude
from morph.record.clock import thinned
from morph.record.quantities import WXYZ, XYZ
from morph.record.recording import Channel, Note, Recording

STANDS = 0.002
"""Height above the lowest point, m, at which a point's weight as a foothold has fallen to 1/e."""
UNSURE = 0.003
"""m: how far a place may be off, as white noise at the rate of readings: floors give way and feet
roll and slip."""
TINY = 1e-6
"""Weight of all footholds together below which the base is in the air and moves nowhere."""
FARTHEST = 100.0
"""m: shapes nearer than this to the floor are looked at."""


def with_base(recording: Recording, robot: Robot) -> Recording:
    """Return a recording with the pose of a free link, where its inertial sensor and feet tell it.

    See `with_imu_attitude` and `with_leg_odometry`.
    """
    return with_leg_odometry(with_imu_attitude(recording, robot), robot)


def with_leg_odometry(recording: Recording, robot: Robot) -> Recording:
    """Return a recording with the place of a free link that was not read, by its feet.

    The lowest shape touches the floor, and what touches it does not move along it. The first place
    is above the origin. It is noted. Recordings that lack the link's orientation or a joint's
    position, and robots of several free links, of ball joints or without a floor stay as they are.

    Source: Bloesch et al. 2012, Robotics: Science and Systems VIII (legged odometry; here the
    orientation is known, and the filter of the diagnosis weighs the result).

    Args:
        recording: What was recorded.
        robot: Its robot, with the floor in its description.
    """
    free = [joint.link for joint in robot.joints if joint.kind == "free"]
    if len(free) != 1 or any(joint.kind == "ball" for joint in robot.joints):
        return recording
    (link,) = free
    channels = recording.channels
    places = [f"{link}.position.{axis}" for axis in XYZ]
    turns = [f"{link}.orientation.{axis}" for axis in WXYZ]
    hinges = [joint.name for joint in robot.joints if joint.kind != "free"]
    needed = [*turns, *(f"{name}.position" for name in hinges)]
    model = spec_of(robot).compile()
    floor = _floor(model)
    if (
        floor is None
        or any(name in channels for name in places)
        or any(name not in channels for name in needed)
    ):
        return recording
    start = max(float(channels[name].time[0]) for name in needed)
    end = min(float(channels[name].time[-1]) for name in needed)
    time = thinned(channels[turns[0]].time, start, end)
    if len(time) < 2:
        return recording
    base = next(at for at in range(model.njnt) if model.jnt_type[at] == mujoco.mjtJoint.mjJNT_FREE)
    first = int(model.jnt_qposadr[base])
    posture = np.zeros((len(time), model.nq))
    for name in hinges:
        posture[:, model.joint(name).qposadr[0]] = channels[f"{name}.position"].at(time)
    for at, name in enumerate(turns):
        posture[:, first + 3 + at] = channels[name].at(time)
    place = _followed(model, posture, first, floor)
    named = {
        name: Channel(time=time, value=value, noise=UNSURE)
        for name, value in zip(places, place.T, strict=True)
    }
    note = Note(
        what=f"where {link} was is told by its feet on the floor, one of which stands at any time",
        where=f"recording {recording.name}",
    )
    return replace(recording, channels={**channels, **named}, notes=(*recording.notes, note))


def _followed(model: mujoco.MjModel, posture: Array, first: int, floor: int) -> Array:
    """Return the places of a base whose feet do not slip, m, shape (samples, 3).

    Args:
        model: The robot. Only shapes that touch the floor are left to collide.
        posture: Shape (samples, nq), the base at the origin.
        first: Where the base's place stands in it.
        floor: The geom that is the floor.
    """
    touching = (model.geom_contype & model.geom_conaffinity[floor]) | (
        model.geom_conaffinity & model.geom_contype[floor]
    )
    model.geom_contype[:] = (touching > 0).astype(int)
    model.geom_conaffinity[:] = 0
    model.geom_contype[floor], model.geom_conaffinity[floor] = 0, 1
    model.geom_margin[:] = FARTHEST
    data = mujoco.MjData(model)
    result = np.zeros((len(posture), 3))
    place = np.zeros(3)
    holds: list[tuple[int, Array, Array, float]] = []
    for at, now in enumerate(posture):
        data.qpos[:] = now
        data.qpos[first : first + 3] = 0.0
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        contacts = [each for each in data.contact[: data.ncon] if floor in each.geom]
        before, holds = holds, []
        if contacts:
            # From the floor to the shape.
            normal = np.array(contacts[0].frame[:3])
            normal = normal if contacts[0].geom[0] == floor else -normal
            lowest = min(contacts, key=lambda each: float(each.dist))
            low, depth = _point(lowest, normal), float(lowest.dist)
            # What stood and still does has not moved along the floor.
            steps, weights = np.zeros((0, 3)), np.zeros(0)
            for body, local, seen, weight in before:
                point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ local
                above = abs(float(normal @ (point - low)))
                steps = np.vstack([steps, point - seen])
                weights = np.append(weights, weight * np.exp(-above / STANDS))
            if weights.sum() > TINY:
                place = place - weights @ steps / weights.sum()
            # Its height is what lets the lowest shape touch, and is not summed up.
            place = place - normal * (normal @ place + depth)
            for each in contacts:
                body = int(model.geom_bodyid[next(geom for geom in each.geom if geom != floor)])
                point = _point(each, normal)
                local = data.xmat[body].reshape(3, 3).T @ (point - data.xpos[body])
                weight = float(np.exp((depth - float(each.dist)) / STANDS))
                holds.append((body, local, point, weight))
        result[at] = place
    return result


def _point(contact: mujoco.MjContact, normal: Array) -> Array:
    """Return the point of a shape that is nearest to the floor, m, shape (3,)."""
    return np.array(contact.pos) + 0.5 * float(contact.dist) * normal


def _floor(model: mujoco.MjModel) -> int | None:
    """Return the one plane that does not move; None if there are more or none."""
    fixed = model.body_weldid[model.geom_bodyid] == 0
    planes = np.flatnonzero(fixed & (model.geom_type == int(mujoco.mjtGeom.mjGEOM_PLANE)))
    return int(planes[0]) if len(planes) == 1 else None
