"""Policies that hold a posture: servo targets, or motors with proportional-derivative gains."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.limbs import JointTree
from morph.body.robot import Robot
from morph.body.roles import Role, actuator_roles
from morph.body.spec import spec_of
from morph.errors import SearchError
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.pattern import Pattern, Swing
from morph.policy.policy import Action, Observation, Policy, actions_of
from morph.search.family.family import Family, Number

WIDEST = 0.1
"""Farthest from its posture that a joint may be told to stay, rad."""

SOFTEST, FIRST_STIFF, STIFFEST = 1.0, 10.0, 20.0
"""Least, first and greatest stiffness of a motor's spring, in greatest efforts per rad, or in the
robot's weight at its reach where that is less."""

BRIEFEST, FIRST_BRIEF, LONGEST = 0.003, 0.015, 0.1
"""Least, first and greatest damping of a motor, in stiffnesses times s."""


@dataclass(frozen=True, kw_only=True)
class Hold(Family):
    """Policies that hold a posture, a little corrected; mirrored joints are corrected alike.

    A servo is told its set point p + o and holds it by itself; a motor is told
    e + k (p + o - q) - d k v, q and v being the position and velocity of its joint. The correction
    o, the stiffness k and the time d belong to a role, such as both knees.
    """

    action: tuple[Action, ...]
    """Every actuator of the body."""
    roles: tuple[Role, ...]
    """The role of each."""
    posture: tuple[float, ...]
    """p, where the joint of each actuator is to stay, rad or m."""
    carried: tuple[float, ...]
    """e, the effort that each motor gives there, N m or N."""
    sprung: tuple[bool, ...]
    """Which actuators are motors."""
    observation: tuple[Observation, ...]
    """The positions of the motors' joints and then their velocities; nothing without motors."""
    period: float = 0.02
    """How long each command is held, s."""

    def make(self, values: Array) -> Policy:
        """Return the policy of these values: a pattern for servos, linear with motors."""
        free = {number.name: float(v) for number, v in zip(self.numbers, values, strict=True)}
        point = np.array(
            [
                place + role.sense * free[f"{role.name} offset"]
                for place, role in zip(self.posture, self.roles, strict=True)
            ]
        )
        if not any(self.sprung):
            swings = tuple(Swing(offset=float(each)) for each in point)
            return Pattern(swings=swings, action=self.action, period=self.period)
        motors = np.flatnonzero(self.sprung)
        weight = np.zeros((len(self.action), 2 * len(motors)))
        bias = point.copy()
        for column, at in enumerate(motors):
            k, d = (
                10.0 ** free[f"{self.roles[at].name} {key}"] for key in ("stiffness", "damping")
            )
            weight[at, column], weight[at, len(motors) + column] = -k, -d * k
            bias[at] = k * point[at] + self.carried[at]
        return Linear(
            weight=weight,
            bias=bias,
            action=self.action,
            observation=self.observation,
            period=self.period,
        )


def hold(
    robot: Robot,
    posture: Mapping[str, float],
    *,
    carried: Mapping[str, float] | None = None,
    period: float = 0.02,
    widest: float = WIDEST,
) -> Hold:
    """Return the policies that hold a robot near a posture.

    Args:
        robot: The body.
        posture: Where its joints are to stay, by name; those that are not named, at zero.
        carried: What gravity asks of its joints there, by name, N m or N; None for nothing. A
            servo is told that much farther, by its stiffness.
        period: How long each command is held, s.
        widest: Farthest correction of a joint, rad.

    Raises:
        SearchError: It has no actuator.
    """
    action = actions_of(robot)
    if not action:
        raise SearchError(
            "it has no actuator", where=f"robot {robot.name}", fix="give it a motor or a servo"
        )
    driven = [robot.actuator(each.actuator) for each in action]
    sprung = tuple(each.kind != "position" for each in driven)
    found = actuator_roles(robot)
    roles = tuple(found[each.actuator] for each in action)
    names = [each.joint or "" for each in driven]
    efforts = [float((carried or {}).get(name, 0.0)) for name in names]
    model: Any = spec_of(robot).compile()
    strong = strengths(robot, action)
    stiffness = [float(model.actuator(each.name).gainprm[0]) for each in driven]
    numbers: list[Number] = []
    for name in dict.fromkeys(role.name for role in sorted(roles, key=lambda role: role.order)):
        numbers.append(Number(name=f"{name} offset", low=-widest, high=widest, start=0.0))
        motors = [at for at, role in enumerate(roles) if role.name == name and sprung[at]]
        if motors:
            numbers += _spring(name, float(strong[motors].min()))
    held = [name for name, spring in zip(names, sprung, strict=True) if name and spring]
    channels = [f"{name}.{rate}" for rate in ("position", "velocity") for name in held]
    return Hold(
        numbers=tuple(numbers),
        action=action,
        roles=roles,
        posture=tuple(
            float(posture.get(name, 0.0)) + (0.0 if spring else effort / stiff)
            for name, spring, effort, stiff in zip(names, sprung, efforts, stiffness, strict=True)
        ),
        carried=tuple(efforts),
        sprung=sprung,
        observation=observations_of(robot, tuple(channels)) if channels else (),
        period=period,
        # What stands already falls where all its joints are corrected far.
        sigma=0.12,
    )


def strengths(robot: Robot, action: tuple[Action, ...]) -> Array:
    """Return the effort by which the spring of each motor is measured, N m or N.

    It is the motor's limit, but no more than the robot's weight at the end of its reach: by the
    limits that some descriptions state a motor could lift it many times over, and a spring as
    stiff would shake at any control period.
    """
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    weight = robot.mass * float(np.linalg.norm(model.opt.gravity)) * JointTree(model, data).size
    limits = np.array([each.high for each in action])
    return np.minimum(limits, weight) if weight > 0.0 else limits


def _spring(named: str, limit: float) -> list[Number]:
    return [
        Number(name=f"{named} {name}", low=low, high=high, start=start)
        for name, low, start, high in springs(limit)
    ]


def springs(limit: float) -> tuple[tuple[str, float, float, float], ...]:
    """Return name, least, first and greatest logarithm of a motor's stiffness and damping time.

    By their logarithms: ten is to one what one is to a tenth.

    Args:
        limit: The greatest effort of the motor, N m or N.
    """
    stiffness = np.log10(limit * np.array([SOFTEST, FIRST_STIFF, STIFFEST])).tolist()
    damping = np.log10([BRIEFEST, FIRST_BRIEF, LONGEST]).tolist()
    return ("stiffness", *stiffness), ("damping", *damping)
