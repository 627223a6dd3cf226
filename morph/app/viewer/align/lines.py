"""Lines between the parts that a map joins, as thick as they are strong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product

from morph.app.viewer.align.chain_bodies import ChainPlayer
from morph.app.viewer.align.links import middle, parts_of, spoken
from morph.app.viewer.align.transfer_record import Told
from morph.app.viewer.content import Colour, Tie
from morph.policy_transfer.parts import Arrow

SAME: Colour = (0, 114, 178)
"""Of parts that move the same way: blue."""

TURNED: Colour = (213, 94, 0)
"""Of parts of which one moves the other way round: orange. Both are told apart by all eyes."""

FAINT: Colour = (176, 180, 186)
"""Of lines beside the one that is pointed at."""

MOST = 200
"""Most lines of one hop: beyond, nobody can follow any."""

STATES, COMMANDS = "what is seen", "what is told"
"""The two sorts of lines."""


def label(arrow: Arrow) -> str:
    """Return what an arrow is called where it is chosen."""
    return f"{arrow.begin} → {arrow.end}"


def arrows(content: Told, sort: str) -> tuple[Arrow, ...]:
    """Return the arrows of one sort, the source's part first and the target's second."""
    if sort == COMMANDS:
        return content.parts.commands
    # A state of the source is made of the target's; read from left to right it goes the other way.
    return tuple(
        Arrow(begin=each.end, end=each.begin, weight=each.weight) for each in content.parts.states
    )


def links(player: ChainPlayer, sort: str) -> Mapping[str, tuple[str, ...]]:
    """Return which links the numbers of a body are about, by what they are called."""
    if player.body is None or player.figure is None:
        return {}
    result, called = parts_of(player.body), spoken(player.body)
    which = result.commands if sort == COMMANDS else result.states
    return {called.get(name, name): links for name, links in which.items()}


def called(content: Told, source: ChainPlayer, target: ChainPlayer) -> Told:
    """Return a hop whose groups and readings are called with the links that they are about."""
    here, there = ({} if each.body is None else spoken(each.body) for each in (source, target))

    def arrow(each: Arrow, begins: Mapping[str, str], ends: Mapping[str, str]) -> Arrow:
        begin, end = begins.get(each.begin, each.begin), ends.get(each.end, each.end)
        return replace(each, begin=begin, end=end)

    parts = replace(
        content.parts,
        states=tuple(arrow(each, there, here) for each in content.parts.states),
        commands=tuple(arrow(each, here, there) for each in content.parts.commands),
        lost=tuple(there.get(name, name) for name in content.parts.lost),
    )
    return replace(content, parts=parts)


def ties(
    content: Told,
    players: tuple[ChainPlayer, ChainPlayer],
    actors: tuple[int, int],
    sort: str,
    chosen: str,
) -> tuple[Tie, ...]:
    """Return the lines of a hop.

    Args:
        content: The hop.
        players: Source and target.
        actors: Their numbers among the actors.
        sort: Which of the two sorts.
        chosen: Label of the arrow that is pointed at; empty for none.
    """
    here, there = (links(player, sort) for player in players)
    results: list[Tie] = []
    for arrow in arrows(content, sort):
        faint = bool(chosen) and label(arrow) != chosen
        for source, target in product(here.get(arrow.begin, ()), there.get(arrow.end, ())):
            tie = _tie(players, actors, (source, target), arrow, faint=faint)
            results += [] if tie is None else [tie]
    return tuple(results[:MOST])


def unplaced(content: Told, players: tuple[ChainPlayer, ChainPlayer]) -> tuple[str, ...]:
    """Return the parts of a hop's arrows that its bodies do not have."""
    results: list[str] = []
    for sort in (STATES, COMMANDS):
        here, there = (links(player, sort) for player in players)
        for arrow in arrows(content, sort):
            results += [arrow.begin] if here and arrow.begin not in here else []
            results += [arrow.end] if there and arrow.end not in there else []
    return tuple(dict.fromkeys(results))


def _tie(
    players: Sequence[ChainPlayer],
    actors: tuple[int, int],
    ends: tuple[str, str],
    arrow: Arrow,
    *,
    faint: bool,
) -> Tie | None:
    source, target = players[0].figure, players[1].figure
    if source is None or target is None or arrow.weight == 0.0:
        return None
    return Tie(
        source=(actors[0], ends[0]),
        target=(actors[1], ends[1]),
        source_at=middle(source, ends[0]),
        target_at=middle(target, ends[1]),
        strength=0.0 if faint else abs(arrow.weight),
        colour=FAINT if faint else SAME if arrow.weight > 0.0 else TURNED,
    )
