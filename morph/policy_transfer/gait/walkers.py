"""The bodies of the chain to an Aracna-like gait, from printed legs to four-bars."""

from __future__ import annotations

from morph.body.load import load
from morph.body.robot import Robot
from morph.body.vary.apply import vary
from morph.body.vary.heavier import Heavier
from morph.body.vary.scale import Scale
from morph.policy_transfer.gait.mover import Mover, mover
from morph.policy_transfer.gait.servoed import servoed

SECONDS = 3.0
"""How long each walks, s."""

LONGER = 1.25
"""How much longer than printed the upper legs of a wide body are."""

LOAD = 0.06
"""What a loaded body carries besides, kg: a quarter of its mass."""


def wide(robot: Robot) -> Robot:
    """Return a printed quadruped with longer upper legs: it stands as high, and wider."""
    upper = [link.name for link in robot.links if link.name.endswith("upper_leg")]
    stretched = (Scale(link=name, factor=LONGER, along=(1.0, 0.0, 0.0)) for name in upper)
    return vary(robot, *stretched)


def walker(name: str, *, seconds: float = SECONDS) -> Mover:
    """Return a body that walks for so long.

    Args:
        name: As `load` takes it, or `quadruped_wide` or `quadruped_loaded`, which is wide too.
        seconds: How long.
    """
    if name not in ("quadruped_wide", "quadruped_loaded"):
        return mover(servoed(load(name)), seconds=seconds, wet=False)
    robot = wide(load("quadruped_printed"))
    if name == "quadruped_loaded":
        robot = vary(robot, Heavier(link="body", add=LOAD))
    return mover(robot, seconds=seconds, wet=False)
