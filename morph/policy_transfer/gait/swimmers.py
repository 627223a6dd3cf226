"""The bodies of the chain to swimming, from three links to six paddles, all with servos."""

from __future__ import annotations

from pathlib import Path

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.vary.apply import vary
from morph.body.vary.lock import Lock
from morph.policy_transfer.gait.mover import Mover, mover
from morph.policy_transfer.gait.servoed import servoed

SECONDS = 4.0
"""How long each swims, s."""


def planar_snake(robot: Robot) -> Robot:
    """Return a sea snake whose pitch hinges are locked straight: five yaw hinges in a plane."""
    pitches = [joint.name for joint in robot.joints if joint.name.startswith("pitch")]
    return vary(robot, *(Lock(joint=name, at=0.0) for name in pitches))


def swimmer(name: str | Path, *, seconds: float = SECONDS) -> Mover:
    """Return a body that swims for so long.

    Args:
        name: As `load` takes it, or `sea_snake_planar`.
        seconds: How long.
    """
    robot = planar_snake(load("sea_snake")) if name == "sea_snake_planar" else load(name)
    return mover(servoed(robot), seconds=seconds, wet=True)
