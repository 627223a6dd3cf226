"""Align: which part is which, the chain of bodies, and the guard's verdict."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from morph.app.viewer.align.cast import cast
from morph.app.viewer.align.lines import STATES, arrows, label, links, ties, unplaced
from morph.app.viewer.align.performance import Performance
from morph.app.viewer.align.read import story
from morph.app.viewer.align.told import chain_table, hop_notes, hop_tables, verdict
from morph.app.viewer.content import Actor, Colour, Content, Tie
from morph.app.viewer.given import Given
from morph.app.viewer.view import View
from morph.errors import ViewError

if TYPE_CHECKING:
    pass

WHOLE, NOTHING = "the whole chain", "nothing"
"""Choices beside the hops and the parts."""

HELD: Colour = (255, 196, 0)
"""Of the links that are pointed at."""


class Align(View):
    """Source and target, with lines between the parts that a map joins.

    Args:
        shared: The story, its bodies and their motions, the same for all who look.
    """

    name: ClassVar[str] = "align"
    title: ClassVar[str] = "Align"

    def __init__(self, shared: Performance) -> None:
        """Begin with the whole chain, or with the only hop."""
        self._shared, self._story = shared, shared.story
        self._hop = 0 if len(self._story.hops) > 1 else 1
        self._sort, self._part, self._large = STATES, "", True
        self._way = self._best()
        self._panel: dict[str, Any] = {}

    def content(self) -> Content:
        """Return the bodies of the chain, those of the chosen hop as they are."""
        first, last = self._stretch
        scene = self._shared.scene(first, last, self._way, self._large)
        players = [each for each in self._shared.players if each.figure is not None]
        numbers = {id(each): at for at, each in enumerate(players)}
        actors = []
        seen = 0
        for at, player in enumerate(self._shared.players):
            if player.figure is None:
                continue
            inside = first <= at <= last
            actors.append(
                Actor(
                    figure=player.figure,
                    motion=scene.motions[seen],
                    ghost=not inside,
                    tints=self._tints(at) if inside else {},
                    title=player.name,
                )
            )
            seen += 1
        del numbers
        notes = [*scene.notes, *self._notes()]
        return Content(
            actors=tuple(actors),
            ties=self._ties(),
            tables=self._tables(),
            moments=scene.moments,
            notes=tuple(dict.fromkeys(notes)),
            title=f"{self._story.chain[0]} to {self._story.chain[-1]}",
        )

    @property
    def _stretch(self) -> tuple[int, int]:
        """The first and the last body of what is chosen."""
        return (0, len(self._story.hops)) if self._hop == 0 else (self._hop - 1, self._hop)

    def _best(self) -> str:
        ways = self._shared.ways(*self._stretch)
        return ways[0] if ways else ""

    def _actor(self, at: int) -> int:
        return sum(each.figure is not None for each in self._shared.players[:at])

    def _ties(self) -> tuple[Tie, ...]:
        first, last = self._stretch
        found: list[Tie] = []
        for at in range(first, last):
            pair = (self._shared.players[at], self._shared.players[at + 1])
            numbers = (self._actor(at), self._actor(at + 1))
            found += ties(self._story.hops[at], pair, numbers, self._sort, self._part)
        return tuple(found)

    def _tints(self, at: int) -> dict[str, Colour]:
        """Return the links of a body that the chosen part is about."""
        if not self._part:
            return {}
        first, last = self._stretch
        names = links(self._shared.players[at], self._sort)
        found: dict[str, Colour] = {}
        for hop in range(first, last):
            for arrow in arrows(self._story.hops[hop], self._sort):
                if label(arrow) == self._part and at in (hop, hop + 1):
                    end = arrow.begin if at == hop else arrow.end
                    found.update(dict.fromkeys(names.get(end, ()), HELD))
        return found

    def _tables(self) -> tuple[Any, ...]:
        chain = (chain_table(self._story),) if len(self._story.hops) > 1 else ()
        if self._hop == 0:
            return chain
        return (*hop_tables(self._story.hops[self._hop - 1]), *chain)

    def _notes(self) -> list[str]:
        first, last = self._stretch
        found: list[str] = []
        for at in range(first, last):
            hop = self._story.hops[at]
            pair = (self._shared.players[at], self._shared.players[at + 1])
            found += [f"Guard on {hop.target}: {verdict(hop)}", *hop_notes(hop)]
            lost = unplaced(hop, pair)
            if lost:
                found.append(f"No such part is on the bodies that are drawn: {', '.join(lost)}")
        for player in self._shared.players[first : last + 1]:
            found += player.notes
        return [*found, *self._story.notes]


def maker(given: Given) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page.

    Raises:
        ViewError: The folder cannot be used.
    """
    if given.transfer is None:
        raise ViewError("no folder is named", where="--transfer", fix="name one")
    told = story(given.transfer)
    shared = Performance(told, cast(told, given.robots), given.seed)
    return partial(Align, shared)
