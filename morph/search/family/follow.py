"""Following a course with an arm of servos: postures by inverse kinematics, told ahead of time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.errors import SearchError
from morph.policy.observing import observations_of
from morph.policy.policy import Action, Observation, actions_of
from morph.policy.track import Track
from morph.search.family.family import Family, Number
from morph.task.arm import Arm
from morph.task.track import Course

LATEST = 0.3
"""Farthest ahead of the course that a posture is told, s."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Follow(Family):
    """Trajectories that tell each posture ahead of its time, and a share of what gravity takes.

    A servo lags behind what it is told, and sags under what it carries: how long it lags and
    by how much of its effort over its stiffness it sags are the two numbers.
    """

    action: tuple[Action, ...]
    """Every actuator of the body."""
    observation: tuple[Observation, ...]
    """What the trajectory is of: the positions of the joints."""
    period: float
    """How long each command is held, s."""
    postures: Array
    """Positions of the joints at each control time, rad or m, shape (times, actuators)."""
    sag: Array
    """By how much each servo sags in them, shape (times, actuators)."""

    def make(self, values: Array) -> Track:
        """Return the trajectory of these values: how far ahead, s, and the share of the sag."""
        ahead, share = (float(value) for value in values)
        time = self.period * np.arange(len(self.postures))
        commanded = self.postures + share * self.sag
        command = np.stack([np.interp(time + ahead, time, each) for each in commanded.T], axis=1)
        knots, size = self.postures.shape
        return Track(
            nominal=self.postures,
            command=command,
            gain=np.zeros((knots, size, size)),
            action=self.action,
            observation=self.observation,
            period=self.period,
        )


def follow(robot: Robot, course: Course, *, seconds: float, period: float) -> Follow:
    """Return the trajectories by which an arm of servos follows a course.

    Raises:
        SearchError: One of its actuators is no servo.
    """
    motors = [each.name for each in robot.actuators if each.kind != "position"]
    if motors:
        raise SearchError(
            f"{', '.join(motors)} are motors, and postures can be told to servos alone",
            where=f"robot {robot.name}",
            fix="take the search ddp",
        )
    arm = Arm(robot)
    # A little longer than it runs: what is told ahead of the end must be there.
    time: Array = np.asarray(period * np.arange(round((seconds + LATEST) / period) + 1), float)
    postures = arm.along(course.at(time))
    model: Any = spec_of(robot).compile()
    stiffness = np.array([model.actuator(each.name).gainprm[0] for each in robot.actuators])
    return Follow(
        numbers=(
            Number(name="ahead", low=0.0, high=LATEST, start=0.5 * LATEST),
            Number(name="share of the sag", low=0.0, high=2.0, start=1.0),
        ),
        action=actions_of(robot),
        observation=observations_of(robot, tuple(f"{name}.position" for name in arm.joints)),
        period=period,
        postures=postures,
        sag=np.array([arm.holding(each) for each in postures]) / stiffness,
    )
