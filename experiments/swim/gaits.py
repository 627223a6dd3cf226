"""Gaits of the hexapod swimmer, as patterns: strokes in water, steps on the floor."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from morph.body.robot import Robot
from morph.policy.pattern import Pattern, Swing, pattern

PERIOD = 0.01
"""How long each command is held, s."""

FRONT, MIDDLE, REAR = ("front", "middle", "rear")
SIDES = ("left", "right")

TRIPOD = ("left_front", "left_rear", "right_middle")
"""The legs that step together; the other three step half a period later."""


def straight(
    robot: Robot,
    *,
    amplitude: float = 0.5,
    frequency: float = 2.0,
    lean: float = 0.0,
    left: float = 1.0,
    phase: float = 0.0,
) -> Pattern:
    """Return the swimmer's stroke: all paddles beat about straight back, the middle ones against.

    Args:
        robot: The swimmer.
        amplitude: Of each paddle, rad.
        frequency: Strokes a second, Hz.
        lean: Offset of the rear paddles, rad, and less that of the front ones: positive lifts
            the nose.
        left: Share of the amplitude that the left paddles have; below 1 turns to the left.
        phase: Where in the stroke the clock begins, rad; pi is the stroke the other way round.
    """
    swings = {}
    for side in SIDES:
        for row, offset, shift in ((FRONT, -lean, 0.0), (MIDDLE, 0.0, math.pi), (REAR, lean, 0.0)):
            swings[f"{side}_{row}"] = Swing(
                offset=offset,
                amplitude=amplitude * (left if side == "left" else 1.0),
                frequency=frequency,
                phase=phase + shift,
            )
    return pattern(robot, swings, period=PERIOD)


def row(robot: Robot, *, frequency: float = 1.0, ease: float = 0.5, sense: int = 1) -> Pattern:
    """Return a stroke that drag drives: front and rear paddles turn round, fast as they push.

    Front paddles push below the hull and rear ones above it, so that the hull does not spin.

    Args:
        robot: The swimmer.
        frequency: Turns a second, Hz.
        ease: How much faster than on average the push is, and how much slower the way back.
        sense: 1, or -1 for the same run backward in time.
    """
    turn = 2.0 * math.pi * frequency * sense
    swings = {}
    for side in SIDES:
        for place, way in ((FRONT, 1.0), (REAR, -1.0)):
            swings[f"{side}_{place}"] = Swing(
                offset=-way * math.pi / 2.0,
                rate=way * turn,
                amplitude=way * sense * ease,
                frequency=frequency,
            )
    return pattern(robot, swings, period=PERIOD)


def tripod(robot: Robot, *, frequency: float = 0.5, ease: float = 0.5) -> Pattern:
    """Return a walk: legs turn round, three at a time, slow below and fast above.

    Source: Saranli, Buehler and Koditschek 2001, RHex: A simple and highly mobile hexapod robot,
    Int. J. Robotics Research 20(7): alternating tripods of legs that turn.

    Args:
        robot: The swimmer.
        frequency: Turns a second, Hz.
        ease: How much slower than on average a leg turns as it stands.
    """
    swings = {}
    for side in SIDES:
        for place in (FRONT, MIDDLE, REAR):
            name = f"{side}_{place}"
            shift = 0.0 if name in TRIPOD else math.pi
            # A leg points down at -pi/2, and is slowest where the sine's slope is least.
            swings[name] = Swing(
                offset=-1.5 * math.pi + shift,
                rate=2.0 * math.pi * frequency,
                amplitude=ease,
                frequency=frequency,
                phase=shift,
            )
    return pattern(robot, swings, period=PERIOD)


def begun(policy: Pattern, robot: Robot) -> Mapping[str, float]:
    """Return the positions of the joints where a gait begins, for a run to start from."""
    now = np.zeros(1)
    return {
        robot.driven_by(a).name: float(policy.by_clock(a.name, now)[0]) for a in robot.actuators
    }
