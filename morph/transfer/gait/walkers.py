"""The bodies of the chain to an Aracna-like gait, from one leg to four-bars, all with servos."""

from __future__ import annotations

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.vary.apply import vary
from morph.body.vary.scale import Scale
from morph.transfer.gait.mover import Mover, mover
from morph.transfer.gait.servoed import servoed

SECONDS = 3.0
"""How long each walks, s."""

LONGER = 1.25
"""How much longer than printed the lower legs of the body between are."""


def long_legged(robot: Robot) -> Robot:
    """Return a printed quadruped with longer lower legs, on the way to one of four-bars."""
    lower = [link.name for link in robot.links if link.name.endswith("lower_leg")]
    return vary(robot, *(Scale(link=name, factor=LONGER) for name in lower))


def walker(name: str, *, seconds: float = SECONDS) -> Mover:
    """Return a body that walks for so long.

    Args:
        name: As `load` takes it, or `quadruped_long_legged`.
        seconds: How long.
    """
    long = name == "quadruped_long_legged"
    robot = long_legged(load("quadruped_printed")) if long else load(name)
    return mover(servoed(robot), seconds=seconds, wet=False)
