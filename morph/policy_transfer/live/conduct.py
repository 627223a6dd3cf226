"""How a live target behaved in a trial: its timing, what was held back, and what was noticed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import JSON, Array
from morph.body.robot import Robot

MOVED = 0.1
"""Movement, rad or m, from which the slope of a position says something of its velocity."""

SLOPE_OFF = 0.5
"""How far from 1 the slope of a position over its velocity is before it is said."""


@dataclass(frozen=True, kw_only=True)
class Conduct:
    """What is said of one trial beside what it showed."""

    samples: int
    """States that came."""
    wanted: int
    """States that were to come."""
    stopped: str
    """Why it ended early, in words; empty if it did not."""
    safe: bool
    """Whether the target said that it stopped, at the end."""
    overruns: int
    """Control periods that morph was too slow for: the command before was held."""
    slowest: float
    """Longest time that morph took from a state to its command, s."""
    irregular: int
    """States that came early or late."""
    latest: float
    """How late the latest state was, s, counted from the first."""
    clipped: int
    """Commands that were held back by a limit."""
    unreadable: int
    """Lines that were no messages."""
    delay: float | None
    """How late commands are obeyed, s; None if the trial does not tell."""
    delay_error: float | None
    """Its standard error, s."""
    notes: tuple[str, ...]
    """What else was noticed, in words."""

    def said(self) -> JSON:
        """Return it as plain data."""
        return {**vars(self), "notes": list(self.notes)}


def odd_velocities(
    robot: Robot, model: object, position: Array, velocity: Array, period: float
) -> list[str]:
    """Return, in words, which velocities are not the slopes of their positions.

    The change of a position over a period is fitted as b times the mean of the velocities at
    its ends; b is 1 where both are in the same unit, and 57.3 where one is in degrees.
    """
    results = []
    for joint in robot.joints:
        if joint.kind not in {"hinge", "slide"} or len(position) < 10:
            continue
        here = model.joint(joint.name)  # type: ignore[attr-defined]
        q, v = position[:, here.qposadr[0]], velocity[:, here.dofadr[0]]
        mean = 0.5 * (v[1:] + v[:-1]) * period
        if np.ptp(q) < MOVED:
            continue
        power = float(mean @ mean)
        slope = float(mean @ np.diff(q)) / power if power > 0.0 else np.inf
        if abs(slope - 1.0) > SLOPE_OFF:
            unit = joint.unit
            results.append(
                f"{joint.name}.position changes by {slope:.3g} times {joint.name}.velocity: one of "
                f"them is not in {unit} or {unit}/s, or dead, or a hinge is counted round and round"
            )
    return results
