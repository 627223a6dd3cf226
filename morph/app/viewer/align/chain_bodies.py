"""Bodies of a chain: looked up by name, posed and drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from morph.app.viewer.align.board_figure import dressed
from morph.app.viewer.align.transfer_record import Story
from morph.app.viewer.figure import Figure, figure
from morph.body import shelf
from morph.body.load import load
from morph.body.robot import Robot
from morph.errors import MorphError, TransferError
from morph.files import sha256
from morph.policy_transfer.balancers import PUSHED, pushed, seen_with
from morph.policy_transfer.body import Body, body
from morph.policy_transfer.riders import FEET, PUSHES, RIDERS, riding
from morph.policy_transfer.skateboard_bodies import Board

TASK = "balance"
"""What bodies of a relay do."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ChainPlayer:
    """One body of the chain."""

    name: str
    """What the record calls it."""
    figure: Figure | None
    """What it looks like; None if there is no such body here."""
    body: Body | None
    """Its simulation, its readings without noise; None if it cannot be made to move."""
    notes: tuple[str, ...] = ()
    """What is to be known of it."""

    @property
    def whole(self) -> bool:
        """Whether a state that is seen tells the state of every joint."""
        return self.body is not None and self.body.sight is None


def cast(story: Story, robots: Sequence[Robot]) -> tuple[ChainPlayer, ...]:
    """Return the bodies of a story in the order of its chain.

    A body is looked for among the robots that were named beside the folder, then on the shelf.
    A path that stands in the folder's record is never followed: a stranger may have written it.

    Args:
        story: What the folder tells.
        robots: Robots that were named beside it.
    """
    known: dict[tuple[str, str | None], ChainPlayer] = {}
    players = []
    requested = story.asked if len(story.asked) == len(story.chain) else ("",) * len(story.chain)
    for name, word in zip(story.chain, requested, strict=True):
        if (name, word) not in known:
            known[name, word] = _player(name, word, story, robots)
        players.append(known[name, word])
    return tuple(players)


def _player(name: str, requested: str | None, story: Story, robots: Sequence[Robot]) -> ChainPlayer:
    if requested is None:
        return ChainPlayer(
            name=name,
            figure=None,
            body=None,
            notes=(f"{name} was only recorded: there is no body of it to draw",),
        )
    try:
        robot, feet, board = _found(name, requested, _by_hash(name, story, robots))
    except MorphError as error:
        return ChainPlayer(name=name, figure=None, body=None, notes=(_unknown(name, story, error),))
    try:
        whole = _moving(robot, feet, board)
    except MorphError as error:
        return ChainPlayer(
            name=name,
            figure=figure(robot, name=name),
            body=None,
            notes=(f"{name} stands still: {error.what}",),
        )
    placed = whole.task.robot
    drawn = figure(placed) if board is None else dressed(placed, robot)
    return ChainPlayer(
        name=name, figure=drawn, body=seen_with(whole, 0.0), notes=_changed(name, placed, story)
    )


def _found(
    name: str, requested: str, robots: Sequence[Robot]
) -> tuple[Robot, tuple[str, str] | None, str | None]:
    """Return a robot, and if it rides a board its feet and how the board rolls.

    Raises:
        MorphError: There is none.
    """
    rider = RIDERS.get(requested)
    if rider is not None:
        return _named(rider.robot, robots), rider.feet, rider.board
    bare, _, board = name.partition("+board(")
    if not board:
        return _named(name, robots, requested), None, None
    # ROBOT@BOARD:LEFT,RIGHT, as `morph transfer` is told it.
    place, _, how = requested.rpartition("@")
    left, _, right = how.partition(":")[2].partition(",")
    feet = (left, right) if left and right else FEET
    return _named(bare, robots, place), feet, board.rstrip(")")


def _by_hash(name: str, story: Story, robots: Sequence[Robot]) -> list[Robot]:
    """Return the robots that were named, the one first that the record was made of."""
    return sorted(robots, key=lambda each: _hash(each) != story.hashes.get(name))


def _hash(robot: Robot) -> str:
    return robot.sha256 or sha256(robot.mjcf)


def _named(name: str, robots: Sequence[Robot], requested: str = "") -> Robot:
    for robot in robots:
        if robot.name == name:
            return robot
    # Only a name of the shelf is looked up; anything else of a record could be any path.
    if requested in shelf.names():
        result = load(shelf.find(requested))
        if result.name == name:
            return result
    return load(shelf.find(name))


def _moving(robot: Robot, feet: tuple[str, str] | None, board: str | None) -> Body:
    if feet is not None:
        kinds: tuple[Board, ...] = tuple(PUSHES)
        for kind in kinds:
            if kind == board:
                return riding(robot, feet, kind)
        raise TransferError(
            f"no board is {board!r}; there are {', '.join(kinds)}",
            where=f"body {robot.name}",
            fix="see `morph transfer --help`",
        )
    if robot.name in PUSHED:
        return pushed(robot, PUSHED[robot.name])
    from morph.task.tasks import task

    return body(task(TASK, robot))


def _unknown(name: str, story: Story, error: MorphError) -> str:
    return (
        f"{name} is not drawn: {error.what.rstrip('.')}. Name its description before the folder, "
        f"and it is: morph view DESCRIPTION --transfer {story.folder}"
    )


def _changed(name: str, robot: Robot, story: Story) -> tuple[str, ...]:
    """Return a note if a body is not the one that the record was made of."""
    # Bodies that share a name are told by a number behind it.
    before = {
        value
        for key, value in story.hashes.items()
        if key == name or (key.startswith(f"{name} ") and key[len(name) + 1 :].isdigit())
    }
    if not before or _hash(robot) in before:
        return ()
    return (
        f"{name} is not the body that this was found on: its description differs since, so that "
        "parts and motions may not be those of the record",
    )
