"""Align: which part is which, the chain of bodies, and the guard's verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from morph.app.viewer.align.align_content import chain_table, hop_notes, hop_tables, verdict
from morph.app.viewer.align.chain_bodies import ChainPlayer, cast
from morph.app.viewer.align.choices import AlignChoices, choices_of
from morph.app.viewer.align.lines import arrows, label, links, ties, unplaced
from morph.app.viewer.align.panel import panel
from morph.app.viewer.align.performance import Performance
from morph.app.viewer.align.read import story
from morph.app.viewer.align.transfer_record import Told
from morph.app.viewer.content import Actor, CellTable, Colour, Content, Tie
from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.arrays import JSON
from morph.errors import ViewError

if TYPE_CHECKING:
    from morph.app.viewer.session import Session

TURNED_ROUND = (
    "Turned round means that a joint counts the other way: where one angle grows the other falls"
)
"""What the colour of a line means, where it could be taken for what is seen."""

HELD: Colour = (255, 196, 0)
"""Of the links that are pointed at."""


class AlignView(View):
    """Source and target, with lines between the parts that a map joins.

    Args:
        shared: The story, its bodies and their motions, the same for all who look.
    """

    name: ClassVar[str] = "align"
    title: ClassVar[str] = "Align"

    def __init__(self, shared: Performance) -> None:
        """Begin with the whole chain, or with the only hop."""
        self._shared, self._told = shared, shared.story.hops
        self.chosen = self.at_hop(0 if len(self._told) > 1 else 1)

    @property
    def hops(self) -> tuple[str, ...]:
        """What the hops are called, no two the same."""
        return tuple(
            f"{number}: {hop.source} → {hop.target}" for number, hop in enumerate(self._told, 1)
        )

    @property
    def ways(self) -> tuple[str, ...]:
        """What may move."""
        return self._shared.ways(*self._stretch)

    @property
    def labels(self) -> tuple[str, ...]:
        """What the arrows of what is chosen are called."""
        return tuple(
            dict.fromkeys(
                label(arrow) for _, hop in self._hops() for arrow in arrows(hop, self.chosen.sort)
            )
        )

    def at_hop(self, number: int) -> AlignChoices:
        """Return what is chosen at first for a hop, or by 0 for the whole chain."""
        result = AlignChoices(hop=number, way="")
        ways = self._shared.ways(*_stretch(result, len(self._told)))
        return AlignChoices(hop=number, way=ways[0] if ways else "")

    def part_at(self, actor: int, link: str) -> str:
        """Return the label of an arrow at a link: one after another, and in the end none."""
        results = [
            label(arrow)
            for at, hop in self._hops()
            for arrow in arrows(hop, self.chosen.sort)
            for player, end in ((at, arrow.begin), (at + 1, arrow.end))
            if self._actor(player) == actor
            and self._shared.players[player].figure is not None
            and link in links(self._shared.players[player], self.chosen.sort).get(end, ())
        ]
        turn = [*dict.fromkeys(results), ""]
        return (
            turn[(turn.index(self.chosen.part) + 1) % len(turn)]
            if (self.chosen.part in turn[:-1])
            else turn[0]
        )

    def content(self) -> Content:
        """Return the bodies of the chain, those beside the chosen hop as ghosts."""
        first, last = self._stretch
        scene = self._shared.scene(first, last, self.chosen.way, self.chosen.large)
        drawn = [(at, each) for at, each in enumerate(self._shared.players) if each.figure]
        return Content(
            actors=tuple(
                Actor(
                    figure=player.figure,
                    motion=motion,
                    ghost=not first <= at <= last,
                    tints=self._tints(at),
                    title=player.name,
                )
                for (at, player), motion in zip(drawn, scene.motions, strict=True)
                if player.figure is not None
            ),
            ties=tuple(self._ties()),
            tables=self._tables(),
            moments=scene.moments,
            notes=tuple(
                note if note.endswith(".") else f"{note}."
                for note in dict.fromkeys((*self._verdicts(), *scene.notes, *self._notes()))
            ),
            title=f"{self._shared.story.chain[0]} to {self._shared.story.chain[-1]}",
        )

    def complete(self) -> None:
        """Wait until the motion that is chosen is there."""
        self._shared.scene(*self._stretch, self.chosen.way, self.chosen.large)

    def panel(self, gui: Any, session: Session) -> None:
        """Add its controls to the page."""
        panel(self, gui, session)

    def state(self) -> JSON:
        """Return what is chosen."""
        return self.chosen.said()

    def restore(self, state: JSON) -> None:
        """Choose what an earlier `state` said."""
        chosen = choices_of(state, len(self._told))
        if chosen.hop == 0 and len(self._told) == 1:
            raise ViewError(
                "it shows a chain, and there is but one hop",
                where="the state of the view align",
                fix="give a state that was saved of this transfer",
            )
        self.chosen = chosen

    @property
    def _stretch(self) -> tuple[int, int]:
        return _stretch(self.chosen, len(self._told))

    def _hops(self) -> Iterator[tuple[int, Told]]:
        """Yield the hops that are chosen, with the number of their first body."""
        first, last = self._stretch
        yield from enumerate(self._told[first:last], first)

    def _pair(self, at: int) -> tuple[ChainPlayer, ChainPlayer]:
        return self._shared.players[at], self._shared.players[at + 1]

    def _actor(self, at: int) -> int:
        """Return the number of the actor that a body of the chain is, if it is drawn."""
        return sum(each.figure is not None for each in self._shared.players[:at])

    def _ties(self) -> Iterator[Tie]:
        for at, hop in self._hops():
            actors = (self._actor(at), self._actor(at + 1))
            yield from ties(hop, self._pair(at), actors, self.chosen.sort, self.chosen.part)

    def _tints(self, at: int) -> dict[str, Colour]:
        """Return the colour of the links of a body that the chosen part is about."""
        if not self.chosen.part:
            return {}
        names = links(self._shared.players[at], self.chosen.sort)
        ends = [
            arrow.begin if at == hop_at else arrow.end
            for hop_at, hop in self._hops()
            for arrow in arrows(hop, self.chosen.sort)
            if at in (hop_at, hop_at + 1) and label(arrow) == self.chosen.part
        ]
        return {link: HELD for end in ends for link in names.get(end, ())}

    def _tables(self) -> tuple[CellTable, ...]:
        chain = (chain_table(self._shared.story),) if len(self._told) > 1 else ()
        if self.chosen.hop == 0:
            return chain
        return (*hop_tables(self._told[self.chosen.hop - 1]), *chain)

    def _verdicts(self) -> Iterator[str]:
        for _, hop in self._hops():
            yield verdict(hop)

    def _notes(self) -> Iterator[str]:
        first, last = self._stretch
        for at, hop in self._hops():
            yield from hop_notes(hop)
            lost = unplaced(hop, self._pair(at))
            if lost:
                yield f"The bodies that are drawn have no {', no '.join(lost[:8])}"
        for player in self._shared.players[first : last + 1]:
            yield from player.notes
        if any(each.weight < 0.0 for _, hop in self._hops() for each in hop.parts.states):
            yield TURNED_ROUND
        yield from self._shared.story.notes


def maker(given: ViewRequest) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page.

    Raises:
        ViewError: The folder cannot be used.
    """
    if given.transfer is None:
        raise ViewError("no folder is named", where="--transfer", fix="name one")
    known = story(given.transfer)
    shared = Performance(known, cast(known, given.robots), given.seed)
    # What is shown first is there when the first person comes.
    AlignView(shared).complete()
    return partial(AlignView, shared)


def _stretch(chosen: AlignChoices, hops: int) -> tuple[int, int]:
    """Return the first and the last body of what is chosen."""
    return (0, hops) if chosen.hop == 0 else (chosen.hop - 1, chosen.hop)
