"""How far a live target may be driven: commands are clipped, positions and speeds are watched."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from morph.arrays import Array, Mask
from morph.body.robot import Joint, Robot
from morph.errors import TransferError
from morph.nearest import nearest
from morph.policy.policy import actions_of


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Limits by the names of actuators and joints, beside those of the description."""

    command: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Least and greatest command of an actuator; greater ones are clipped."""
    rate: Mapping[str, float] = field(default_factory=dict)
    """Most that the command of an actuator may change in a second; more is clipped."""
    position: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Least and greatest position of a joint, rad or m; beyond it, or beyond the description's, the
    trial is stopped."""
    speed: Mapping[str, float] = field(default_factory=dict)
    """Greatest speed of a joint, rad/s or m/s; beyond it, or beyond the description's, the trial is
    stopped."""
    slack: float = 0.05
    """How far beyond a limit of the description a reading may be, rad or m, and per s."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name, (low, high) in {**self.command, **self.position}.items():
            if not low <= high:
                _refuse(f"the limits of {name} are {low:g} and {high:g}", "the lesser first")
        for name, most in {**self.rate, **self.speed, "slack": self.slack}.items():
            if not most >= 0.0:
                _refuse(f"the limit of {name} is {most:g}", "give 0 or more")


class LimitGuard:
    """What keeps one body within its limits.

    Args:
        limits: The user's.
        robot: The body, which has limits too.
        model: Its compiled `mujoco.MjModel`.
        period: How long each command is held, s.

    Raises:
        TransferError: A limit names no part of the body.
    """

    def __init__(self, limits: Limits, robot: Robot, model: Any, period: float) -> None:
        joints = [joint for joint in robot.joints if joint.kind in {"hinge", "slide"}]
        actuators = [each.name for each in robot.actuators]
        _known({**limits.command, **limits.rate}, actuators, "actuator")
        _known({**limits.position, **limits.speed}, [joint.name for joint in joints], "joint")
        actions = actions_of(robot)
        bounds = [
            (max(x.low, low), min(x.high, high))
            for x in actions
            for low, high in [limits.command.get(x.actuator, (-math.inf, math.inf))]
        ]
        self.low, self.high = (np.array(each) for each in zip(*bounds, strict=True))
        if (self.low > self.high).any():
            _refuse("a limit of a command is outside the actuator's own", "give limits within it")
        self._change = period * np.array([limits.rate.get(name, math.inf) for name in actuators])
        # A servo starts from where its joint is; the effort of a motor starts from none.
        self._servo = [
            int(model.joint(each.joint).qposadr[0]) if each.kind == "position" else -1
            for each in robot.actuators
        ]
        self._joints = [_watched(joint, limits, model) for joint in joints]

    def rest(self, position: Array) -> Array:
        """Return what actuators are told that are to do nothing at a position (nq,); (nu,)."""
        rest = [0.0 if at < 0 else float(position[at]) for at in self._servo]
        return np.asarray(np.clip(np.array(rest), self.low, self.high))

    def allowed(self, command: Array, before: Array) -> tuple[Array, Mask]:
        """Return a command within all limits, and which actuators were held back, (nu,) each.

        Args:
            command: What is asked for, finite.
            before: What was told last.
        """
        near = np.clip(command, before - self._change, before + self._change)
        # The bounds count more than the rate.
        allowed = np.clip(near, self.low, self.high)
        return allowed, allowed != command

    def breach(self, position: Array, velocity: Array) -> str | None:
        """Return what a state is beyond, in words; None if it is within all limits."""
        for joint, at, rate, (low, high), most in self._joints:
            q, v = float(position[at]), float(velocity[rate])
            if not low <= q <= high:
                return (
                    f"{joint.name} is at {q:.4g} {joint.unit}, beyond its limits {low:g} and "
                    f"{high:g} {joint.unit}"
                )
            if abs(v) > most:
                return (
                    f"{joint.name} moves at {v:.4g} {joint.unit}/s, beyond its limit {most:g} "
                    f"{joint.unit}/s"
                )
        return None


def _watched(
    joint: Joint, limits: Limits, model: Any
) -> tuple[Joint, int, int, tuple[float, float], float]:
    """Return a joint, where its position and velocity stand, and its limits."""
    low, high = joint.limits or (-math.inf, math.inf)
    # The user's limits count beside the description's: neither loosens the other.
    least, most = limits.position.get(joint.name, (-math.inf, math.inf))
    least, most = max(least, low - limits.slack), min(most, high + limits.slack)
    if least > most:
        _refuse(
            f"the limits of {joint.name} are outside those of the description, {low:g} to {high:g} "
            f"{joint.unit}",
            "give limits within them",
        )
    speed = math.inf if joint.velocity is None else joint.velocity + limits.slack
    here = model.joint(joint.name)
    return (
        joint,
        int(here.qposadr[0]),
        int(here.dofadr[0]),
        (least, most),
        min(limits.speed.get(joint.name, math.inf), speed),
    )


def _known(named: Mapping[str, object], known: list[str], what: str) -> None:
    for name in named:
        if name not in known:
            _refuse(f"there is no {what} {name!r}", f"the nearest are {nearest(name, known)}")


def _refuse(what: str, fix: str) -> None:
    raise TransferError(what, where="limits of a live target", fix=fix)
