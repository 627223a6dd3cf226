"""Strides of bodies with motors: springs and dampers whose set points swing as in a gait."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.policy.observing import observations_of
from morph.policy.policy import Action, Observation, actions_of
from morph.policy.track import Track
from morph.search.family.family import Family, Number
from morph.search.family.gait import Gait, gait, room_about
from morph.search.family.posture_policies import springs, strengths

WIDEST = 0.6
"""Farthest that a set point swings from the posture, rad."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stride(Family):
    """Trajectories u = k (p + g(t) - q) - d k v: g is a gait, and k is by each motor's strength."""

    gait: Gait
    """What swings, in rad about the posture; its numbers are the first of this family's."""
    action: tuple[Action, ...]
    """Every actuator of the body, in N m."""
    observation: tuple[Observation, ...]
    """The positions of the motors' joints, and then their velocities."""
    posture: Array
    """p, where the joints are between their swings, rad, shape (actuators,)."""
    strength: Array
    """The effort by which each spring is measured, N m, shape (actuators,)."""
    seconds: float
    """How long a trajectory is, s; then it stands still."""
    period: float
    """How long each command is held, s."""

    def make(self, values: Array) -> Track:
        """Return the trajectory of these values: those of the gait, then stiffness and damping."""
        *swung, stiffness, damping = values
        pattern = self.gait.make(np.array(swung))
        time: Array = np.asarray(
            self.period * np.arange(round(self.seconds / self.period) + 1), float
        )
        point = np.asarray(pattern.act(np.empty((len(time), 0)), time) + self.posture)
        k = 10.0**stiffness * self.strength
        gain = -np.hstack([np.diag(k), np.diag(10.0**damping * k)])
        return Track(
            nominal=np.hstack([point, np.zeros_like(point)]),
            command=np.zeros((len(time), len(self.action))),
            gain=np.broadcast_to(gain, (len(time), *gain.shape)),
            action=self.action,
            observation=self.observation,
            period=self.period,
        )


def stride(robot: Robot, posture: Mapping[str, float], *, seconds: float, period: float) -> Stride:
    """Return the strides of a robot with motors about a posture.

    Raises:
        SearchError: It has no actuator.
    """
    joints = [robot.driven_by(each) for each in robot.actuators]
    place, room = room_about(robot, posture, WIDEST)
    walked = gait(robot, period=period, action=room)
    channels = [f"{joint.name}.{rate}" for rate in ("position", "velocity") for joint in joints]
    numbers = [
        Number(name=name, low=low, high=high, start=start)
        for name, low, start, high in springs(1.0)
    ]
    action = actions_of(robot)
    return Stride(
        numbers=(*walked.numbers, *numbers),
        gait=walked,
        action=action,
        strength=strengths(robot, action),
        observation=observations_of(robot, tuple(channels)),
        posture=place,
        seconds=seconds,
        period=period,
    )
