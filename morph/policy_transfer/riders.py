"""Humanoids on skateboards, each with a push fixed beforehand."""

from __future__ import annotations

from dataclasses import dataclass

from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import TransferError
from morph.policy_transfer.body import Body
from morph.policy_transfer.rest_on_contacts import standing
from morph.policy_transfer.skateboard_bodies import Board, on_board
from morph.task.push import Push

PUSHES: dict[Board, float] = {"driven": 3.85, "passive": 5.0, "free": 2.5}
"""Impulse on the pelvis along the board, N s: holding still falls, and feedback can stand it."""

PELVIS = "pelvis"
"""What is pushed."""


@dataclass(frozen=True, kw_only=True)
class Rider:
    """A humanoid of the shelf on a board."""

    robot: str
    """Its name on the shelf."""
    feet: tuple[str, str]
    """Its left and its right foot."""
    board: Board
    """How the board rolls."""


FEET = ("left_foot", "right_foot")

RIDERS = {
    "humanoid_driven": Rider(robot="humanoid", feet=FEET, board="driven"),
    "humanoid_passive": Rider(robot="humanoid", feet=FEET, board="passive"),
    "humanoid_free": Rider(robot="humanoid", feet=FEET, board="free"),
}
"""The humanoid with its feet held to a board on a rail, and standing free on one with wheels."""


def rider(name: str) -> Body:
    """Return a humanoid of the shelf on a board, with its push.

    Raises:
        TransferError: There is no such rider.
    """
    if name not in RIDERS:
        raise TransferError(
            f"there is no rider {name}",
            where="a humanoid on a skateboard",
            fix=f"give one of {', '.join(RIDERS)}",
        )
    result = RIDERS[name]
    return riding(load(result.robot), result.feet, result.board)


def riding(robot: Robot, feet: tuple[str, str], board: Board) -> Body:
    """Return a floating humanoid put on a board, with its task and its push.

    Raises:
        RobotError: It does not float, or lacks a foot or a pelvis.
        SearchError: It does not stand by itself.
    """
    robot.link(PELVIS)
    placed = on_board(robot, feet, board=board)
    under = {link.name for link in robot.links}
    carriers = tuple(link.name for link in placed.links if link.name not in under)
    push = Push(link=PELVIS, impulse=(PUSHES[board], 0.0, 0.0))
    return standing(placed, feet, carriers, push=push)
