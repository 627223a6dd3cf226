"""What a recording reads of a robot's state: one channel for each degree of freedom."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import DiagnosisError
from morph.record.quantities import XYZ, pose_channels
from morph.record.recording import Channel, Recording
from morph.record.spikes import spikes, without_spikes
from morph.sim.tangent import (
    BALL,
    FREE,
    HINGE,
    SLIDE,
    Coordinates,
    conjugate,
    product,
    rotation,
    turned,
)

KINDS = {"hinge": HINGE, "slide": SLIDE, "ball": BALL, "free": FREE}
QUARTER = 0.5**0.5
"""Product of two unit quaternions that are a quarter turn apart: the cosine of half of it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Measurement:
    """How channels of a recording read the state of a robot.

    A hinge or slide is read by its position, a free joint by the pose of its link: three channels
    of the place, in the world, and three of the rotation from the measured orientation to the
    state's, a vector along the world's axes. Those read zero, whatever was measured. A ball joint
    has the latter three, along the axes of the link that carries it.
    """

    coordinates: Coordinates
    """Where joints stand in a state."""
    channels: tuple[str, ...]
    """Names by degree of freedom: `elbow.position`, `hull.position.x`, `hull.rotation.x`."""
    units: tuple[str, ...]
    """Their units, m or rad."""
    recorded: tuple[str, ...]
    """Channels of a recording that hold the coordinates that are numbers, in their order."""
    quaternions: tuple[tuple[str, ...], ...]
    """Channels that hold each quaternion, w first."""

    @classmethod
    def of(cls, robot: Robot) -> Measurement:
        """Return the measurement of a robot.

        Raises:
            DiagnosisError: The robot has no joint that moves, or a ball joint that is named as a
                link is.
        """
        links = {link.name for link in robot.links}
        for joint in robot.joints:
            if joint.kind == "ball" and joint.name in links:
                raise DiagnosisError(
                    f"the ball joint {joint.name} and a link have one name: "
                    f"{joint.name}.orientation.w tells of the link",
                    where=f"robot {robot.name}",
                    fix="give the joint another name in the description",
                )
        if not robot.joints:
            raise DiagnosisError(
                "it has no joint that moves",
                where=f"robot {robot.name}",
                fix="give a description with at least one joint that moves",
            )
        channels: list[str] = []
        units: list[str] = []
        recorded: list[str] = []
        quaternions: list[tuple[str, ...]] = []
        for joint in robot.joints:
            names = pose_channels(joint)
            if joint.kind in {"free", "ball"}:
                place, turn = names[:-4], names[-4:]
                part = turn[0].removesuffix(".orientation.w")
                channels += [*place, *(f"{part}.rotation.{axis}" for axis in XYZ)]
                units += ["m"] * len(place) + ["rad"] * 3
                recorded += place
                quaternions.append(turn)
            else:
                channels += names
                units.append(joint.unit)
                recorded += names
        return cls(
            coordinates=Coordinates.of([KINDS[joint.kind] for joint in robot.joints]),
            channels=tuple(channels),
            units=tuple(units),
            recorded=tuple(recorded),
            quaternions=tuple(quaternions),
        )

    @property
    def needed(self) -> tuple[str, ...]:
        """Every channel that a recording must have, beside commands."""
        return (*self.recorded, *(name for names in self.quaternions for name in names))

    def tracks(self, recording: Recording) -> list[Channel]:
        """Return the channels that are needed, less spikes; quaternions do not change their sign.

        Those of a quaternion are on the clock of its first.

        Raises:
            RecordingError: A channel is missing.
        """
        results = [without_spikes(recording.channel(name)) for name in self.recorded]
        for names in self.quaternions:
            parts = [recording.channel(name) for name in names]
            whole = _of_one_sign(np.stack([part.at(parts[0].time) for part in parts], axis=1))
            turns = [replace(parts[0], value=values) for values in whole.T]
            kept = ~np.any([spikes(turn) for turn in turns], axis=0)
            results += [
                replace(turn, time=turn.time[kept], value=turn.value[kept]) for turn in turns
            ]
        return results

    def clocks(self, recording: Recording) -> list[Array]:
        """Return the different clocks of these channels, spikes and all, s."""
        names = (*self.recorded, *(first for first, *_ in self.quaternions))
        times = [recording.channel(name).time for name in names]
        return list({time.tobytes(): time for time in times}.values())

    def by_channel(self, tracked: Array) -> Array:
        """Return values of the tracks by channel, a quaternion's first for its rotation.

        Args:
            tracked: Shape (..., tracks).
        """
        if not self.coordinates.balls:
            return tracked
        scalars = len(self.recorded)
        result = np.empty((*tracked.shape[:-1], self.coordinates.dofs), dtype=tracked.dtype)
        result[..., self.coordinates.dof] = tracked[..., :scalars]
        for ball, (_, turn) in enumerate(self.coordinates.balls):
            result[..., turn : turn + 3] = tracked[..., scalars + 4 * ball, None]
        return result

    def spread(self, tracked: Array) -> Array:
        """Return values of the tracks by degree of freedom, rotations zero, (..., nv)."""
        scalars = len(self.recorded)
        if not self.coordinates.balls:
            return tracked
        result = np.zeros((*tracked.shape[:-1], self.coordinates.dofs))
        result[..., self.coordinates.dof] = tracked[..., :scalars]
        return result

    def attitude(self, tracked: Array) -> Array:
        """Return orientations by the values of the tracks, shape (..., balls, 4)."""
        whole = tracked[..., len(self.recorded) :]
        return unit(whole.reshape(*whole.shape[:-1], -1, 4))

    def noise(self, tracked: Array) -> Array:
        """Return the standard deviation of each channel by those of the tracks."""
        result = self.spread(tracked)
        for ball, (_, turn) in enumerate(self.coordinates.balls):
            first = len(self.recorded) + 4 * ball
            # A rotation vector is twice a quaternion's imaginary part.
            squared = np.mean(tracked[first : first + 4] ** 2)
            result[turn : turn + 3] = 2.0 * np.sqrt(squared)
        return result

    def motion(self, value: Array, slope: Array, bend: Array) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations by the tracks' values and derivatives.

        Source: Diebel 2006, Representing Attitude, eq. 156: the rate in the body's axes is
        2 q* dq/dt, and its derivative 2 q* d2q/dt2 but for its real part.
        """
        velocity, acceleration = self.spread(slope), self.spread(bend)
        for ball, (_, turn) in enumerate(self.coordinates.balls):
            part = slice(len(self.recorded) + 4 * ball, len(self.recorded) + 4 * ball + 4)
            back = conjugate(value[..., part])
            back = 2.0 * back / np.sum(value[..., part] ** 2, axis=-1, keepdims=True)
            velocity[..., turn : turn + 3] = product(back, slope[..., part])[..., 1:]
            acceleration[..., turn : turn + 3] = product(back, bend[..., part])[..., 1:]
        position = self.placed(self.spread(value), self.attitude(value))
        return position, velocity, acceleration

    def scalars(self, position: Array) -> Array:
        """Return coordinates that are numbers by degree of freedom, rotations zero, (..., nv).

        Args:
            position: Shape (..., nq).
        """
        if not self.coordinates.balls:
            return position
        result = np.zeros((*position.shape[:-1], self.coordinates.dofs))
        result[..., self.coordinates.dof] = position[..., self.coordinates.straight]
        return result

    def read(self, position: Array, attitude: Array) -> Array:
        """Return what all channels read of positions, shape (..., channels).

        Args:
            position: Shape (..., nq).
            attitude: Measured orientations, unit quaternions, shape (..., balls, 4).
        """
        result = self.scalars(position)
        for ball, (at, turn) in enumerate(self.coordinates.balls):
            quaternion = position[..., at : at + 4]
            result[..., turn : turn + 3] = deviation(quaternion, attitude[..., ball, :])
        return result

    def placed(self, reading: Array, attitude: Array) -> Array:
        """Return positions by what all channels read of them, shape (..., nq).

        Args:
            reading: Shape (..., channels).
            attitude: Measured orientations, unit quaternions, shape (..., balls, 4).
        """
        if not self.coordinates.balls:
            return reading
        result = np.empty((*reading.shape[:-1], self.coordinates.positions))
        result[..., self.coordinates.straight] = reading[..., self.coordinates.dof]
        for ball, (at, turn) in enumerate(self.coordinates.balls):
            by = turned(reading[..., turn : turn + 3])
            result[..., at : at + 4] = product(by, attitude[..., ball, :])
        return result


def deviation(quaternion: Array, measured: Array) -> Array:
    """Return the rotation from a measured orientation to another, rad, shape (..., 3).

    It is along the axes in which they are given: quaternion = Exp(rotation) measured.
    """
    return rotation(product(quaternion, conjugate(measured)))


def _of_one_sign(whole: Array) -> Array:
    """Return quaternions that do not change their sign, shape (samples, 4).

    One reading far from those on both sides, such as an angle averaged over its wrap, says nothing
    of the sign of what follows: that is told by the one before.
    """
    near = np.sum(whole[1:] * whole[:-1], axis=1)
    sign, across = np.where(near < 0.0, -1.0, 1.0), np.sum(whole[2:] * whole[:-2], axis=1)
    far = np.abs(near) < QUARTER
    alone = far[1:] & far[:-1] & (np.abs(across) > QUARTER)
    for at in np.flatnonzero(alone).tolist():
        sign[at + 1] = (-1.0 if across[at] < 0.0 else 1.0) * sign[at]
    result = whole.copy()
    result[1:] *= np.cumprod(sign)[:, None]
    return result


def unit(quaternion: Array) -> Array:
    """Return quaternions of length 1."""
    return np.asarray(quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True))
