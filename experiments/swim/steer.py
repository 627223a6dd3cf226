"""Steering: a gait whose offsets are set anew a few times a stroke, from depth and pitch."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from experiments.swim.gaits import straight
from morph.arrays import Array
from morph.body.robot import Robot
from morph.policy.pattern import Pattern
from morph.record.recording import Channel, Recording
from morph.sim.simulator import Simulator

EVERY = 0.1
"""How often the gait is set anew, s: five times a stroke of 2 Hz."""

POSE = tuple(f"hull.position.{axis}" for axis in "xyz") + tuple(
    f"hull.orientation.{axis}" for axis in "wxyz"
)
SPEED = tuple(f"hull.{kind}_velocity.{axis}" for kind in ("linear", "angular") for axis in "xyz")


@dataclass(frozen=True, kw_only=True)
class Depth:
    """Hold a height by leaning the front and the rear paddles against each other.

    The nose is to point down by k (z - z0) + d dz/dt, at most 0.5 rad; the paddles lean by
    p (pitch - wanted) + r dpitch/dt, at most 0.8 rad. A hull that swims would turn broadside
    if it were left alone (Munk 1924, NACA report 184).
    """

    height: float = 0.0
    """z0, m."""
    k: float = 2.0
    """rad/m."""
    d: float = 1.5
    """rad s/m."""
    p: float = 3.0
    """rad/rad."""
    r: float = 1.5
    """rad s/rad."""

    def lean(self, seen: Recording) -> float:
        """Return the lean of the paddles, rad, from the last samples of a recording."""
        off = seen["hull.position.z"][-1] - self.height
        wanted = self.k * off + self.d * seen["hull.linear_velocity.z"][-1]
        wrong = attitude(seen)[-1, 1] - float(np.clip(wanted, -0.5, 0.5))
        rate = seen["hull.angular_velocity.y"][-1]
        return float(np.clip(self.p * wrong + self.r * rate, -0.8, 0.8))


def attitude(run: Recording) -> Array:
    """Return roll, pitch (positive: nose down) and yaw of the hull, rad, shape (samples, 3).

    Source: Diebel 2006, Representing attitude, eq. 290, rotations about z, then y, then x.
    """
    w, x, y, z = (run[f"hull.orientation.{axis}"] for axis in "wxyz")
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.unwrap(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
    return np.stack([roll, pitch, yaw], axis=-1)


def steered(simulator: Simulator, depth: Depth, seconds: float) -> Recording:
    """Return a run in which the straight gait is leant anew every `EVERY` seconds."""
    robot = simulator.robot
    pieces = [_piece(simulator, straight(robot), 0.0, None)]
    for index in range(1, math.ceil(seconds / EVERY - 1e-9)):
        gait = straight(robot, lean=depth.lean(pieces[-1]))
        pieces.append(_piece(simulator, gait, index * EVERY, pieces[-1]))
    return joined(pieces)


def _piece(
    simulator: Simulator, gait: Pattern, begin: float, before: Recording | None
) -> Recording:
    command = {name: _later(told, begin) for name, told in gait.commands().items()}
    start, speed = ({}, {}) if before is None else _state(simulator.robot, before)
    return simulator.run(seconds=EVERY, start=start, speed=speed, command=command)


def _later(told: Callable[[Array], Array], begin: float) -> Callable[[Array], Array]:
    return lambda times: told(times + begin)


def _state(robot: Robot, run: Recording) -> tuple[dict[str, float], dict[str, float]]:
    """Return where a run ended: positions and velocities by name."""
    moving = [joint.name for joint in robot.joints if joint.kind == "hinge"]
    start = {name: run[name][-1] for name in POSE}
    speed = {name: run[name][-1] for name in SPEED}
    start |= {name: run[f"{name}.position"][-1] for name in moving}
    speed |= {name: run[f"{name}.velocity"][-1] for name in moving}
    return start, speed


def joined(pieces: list[Recording]) -> Recording:
    """Return runs that follow one another, each begun where the last ended, as one."""
    channels = {}
    for name, first in pieces[0].channels.items():
        times, values = [first.time], [first.value]
        step = float(first.time[1] - first.time[0])
        for piece in pieces[1:]:
            channel = piece.channels[name]
            # A measured channel ends where the next begins; a command does not.
            skip = 0 if first.hold else 1
            begin = float(times[-1][-1]) + (step if first.hold else 0.0)
            times.append(begin + channel.time[skip:])
            values.append(channel.value[skip:])
        channels[name] = Channel(
            time=np.concatenate(times), value=np.concatenate(values), hold=first.hold
        )
    return replace(pieces[0], channels=channels)
