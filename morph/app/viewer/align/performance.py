"""How the bodies of a chain move together: one leads, the others are where the maps put them."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from morph.app.viewer.align.cast import Player
from morph.app.viewer.align.laws import law
from morph.app.viewer.align.lines import called
from morph.app.viewer.align.maps import maps_of
from morph.app.viewer.align.story import Story
from morph.app.viewer.content import Moment
from morph.app.viewer.motion import RATE, Motion, motion, posed
from morph.arrays import Array
from morph.transfer.body import Body
from morph.transfer.parts import names_of

PARTS, TARGET, SOURCE = "parts in turn", "the target leads", "the source leads"
"""What may move."""

SWING, PART_SECONDS = 0.35, 2.0
"""How far a part is moved in its turn, rad, and for how long, s."""

SHIFT = 0.15
"""How far a part that slides is moved, by the size of its body."""

LARGER = (1.0, 2.0, 5.0, 10.0, 20.0)
"""By how much motions may be enlarged, so that they are seen."""

VISIBLE = 0.35
"""Up to how large the largest of them may then be, rad or m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """How the bodies of a stretch of the chain move."""

    motions: tuple[Motion, ...]
    """One for each body, in the order of the chain; those without a figure have none."""
    moments: tuple[Moment, ...] = ()
    """When each part has its turn."""
    notes: tuple[str, ...] = ()
    """What moves, and why."""


class Performance:
    """The motions of a story, computed once for all who look.

    Args:
        story: What the folder tells.
        players: Its bodies.
        seed: Of the starts of runs.

    Raises:
        ViewError: A map is spoilt.
    """

    def __init__(self, story: Story, players: Sequence[Player], seed: int = 0) -> None:
        """Read the maps."""
        hops = zip(story.hops, pairwise(players), strict=True)
        self.story = replace(story, hops=tuple(called(hop, *pair) for hop, pair in hops))
        self.players, self._seed = tuple(players), seed
        self.maps = maps_of(story, players)
        self._made: dict[tuple[int, int, str, bool], Scene] = {}
        self._lock = threading.Lock()

    def ways(self, first: int, last: int) -> tuple[str, ...]:
        """Return what may move between two bodies of the chain, what shows most first."""
        players = self.players[first : last + 1]
        found = []
        if players[0].whole:
            found.append(PARTS)
        found += [TARGET] if players[-1].body is not None else []
        found += [SOURCE] if players[0].body is not None else []
        if not all(each.whole for each in players) and TARGET in found:
            found.sort(key=lambda each: each != TARGET)
        return tuple(found)

    def scene(self, first: int, last: int, way: str, large: bool) -> Scene:
        """Return how all bodies move while those of a stretch of the chain do.

        Args:
            first: Number of the stretch's first body.
            last: Number of its last.
            way: What moves, of `ways`; anything else leaves all at rest.
            large: Whether motions are enlarged so that they are seen.
        """
        key = (first, last, way, large)
        with self._lock:
            if key not in self._made:
                self._made[key] = self._scene(*key)
            return self._made[key]

    def _scene(self, first: int, last: int, way: str, large: bool) -> Scene:
        if way not in self.ways(first, last):
            return Scene(motions=tuple(_rest(each) for each in self.players if each.figure))
        if way == PARTS:
            times, states, moments, said = self._turns(first, last)
            ran: dict[int, Array] = {}
        else:
            lead = last if way == TARGET else first
            times, states, ran, said = self._run(first, last, lead)
            moments = ()
        scale = self._scale(states, ran) if large and way != PARTS else 1.0
        notes = [*said, *self._still(first, last, states, ran)]
        if scale > 1.0:
            notes.append(f"Motions are drawn {scale:g} times as large as they are")
        motions = []
        for at, player in enumerate(self.players):
            if player.figure is None:
                continue
            body = player.body
            if body is None or (at not in states and at not in ran):
                motions.append(_rest(player))
            elif body.sight is None and at in states:
                q, _ = body.place(scale * states[at])
                motions.append(motion(player.figure.model, times, q))
            elif at in ran:
                motions.append(motion(player.figure.model, times, ran[at]))
            else:
                motions.append(_rest(player))
        return Scene(motions=tuple(motions), moments=moments, notes=tuple(notes))

    def _turns(
        self, first: int, last: int
    ) -> tuple[Array, dict[int, Array], tuple[Moment, ...], list[str]]:
        """Return the states while each part of the first body has its turn."""
        player = self.players[first]
        body = _body(player)
        ends = {arrow.end for arrow in self.story.hops[first].parts.states}
        names = names_of(body).state[: body.size // 2]
        which = [at for at, name in enumerate(names) if name in ends] or [*range(len(names))]
        samples = round(PART_SECONDS * RATE)
        wave = np.sin(2.0 * np.pi * np.arange(samples) / samples)
        states = np.zeros((samples * len(which), body.size))
        model = body.plant.model
        for turn, at in enumerate(which):
            kind = int(model.jnt_type[model.dof_jntid[at]])
            far = SHIFT * float(model.stat.extent) if kind == 2 else SWING
            states[turn * samples : (turn + 1) * samples, at] = far * wave
        moments = tuple(
            Moment(time=turn * PART_SECONDS, title=f"{names[at]} of {player.name}")
            for turn, at in enumerate(which)
        )
        said = [
            f"Each part of {player.name} is moved in its turn, by hand; the map puts "
            f"{self._others(first, last, first)} where that is"
        ]
        found = self._carried({first: states}, first, last, first)
        return np.arange(len(states)) / RATE, found, moments, said

    def _run(
        self, first: int, last: int, lead: int
    ) -> tuple[Array, dict[int, Array], dict[int, Array], list[str]]:
        """Return the states of all while one runs, and what its joints did."""
        player = self.players[lead]
        body = _body(player)
        moving, words = law(self.story, self.players, self.maps, lead)
        with np.errstate(over="ignore", invalid="ignore"):
            moved = body.run(moving, rows=1, rng=np.random.default_rng([self._seed, 7]))
        q, v = moved.position[0], moved.velocity[0]
        push = body.task.start.push
        began = "" if push is None else f", pushed at {push.link} with {abs(push.impulse[0]):g} N s"
        said = [f"{words}{began}; {self._others(first, last, lead)} shows what the map makes of it"]
        states = {lead: body.seen(body.state(q, v))}
        return moved.time, self._carried(states, first, last, lead), {lead: q}, said

    def _carried(
        self, states: dict[int, Array], first: int, last: int, lead: int
    ) -> dict[int, Array]:
        """Return what the maps make of a body's states all along the stretch."""
        for at in range(lead, first, -1):
            body_map = self.maps[at - 1]
            if body_map is None or at not in states:
                break
            states[at - 1] = body_map.state(states[at])
        for at in range(lead, last):
            body_map = self.maps[at]
            if body_map is None or at not in states:
                break
            states[at + 1] = body_map.state_back(states[at])
        return {at: each for at, each in states.items() if np.isfinite(each).all()}

    def _scale(self, states: dict[int, Array], ran: dict[int, Array]) -> float:
        """Return by how much motions are enlarged: not at all if a body can be shown as is only."""
        if any(not self.players[at].whole for at in ran):
            return 1.0
        shown = [
            np.abs(each[:, : each.shape[1] // 2]).max()
            for at, each in states.items()
            if self.players[at].whole
        ]
        most = max(shown, default=1.0)
        return max(each for each in LARGER if each == 1.0 or each * most <= VISIBLE)

    def _still(
        self, first: int, last: int, states: dict[int, Array], ran: dict[int, Array]
    ) -> list[str]:
        """Return why bodies of the stretch stand still."""
        notes = []
        for at in range(first, last + 1):
            player = self.players[at]
            if player.body is None or at in ran or (player.whole and at in states):
                continue
            reduced = player.body.sight is not None
            notes.append(
                f"{player.name} stands at rest: it is seen by {player.body.size // 2} readings, "
                "and these do not tell where every joint is"
                if reduced
                else f"{player.name} stands at rest: no map leads to it"
            )
        return notes

    def _others(self, first: int, last: int, lead: int) -> str:
        names = [self.players[at].name for at in range(first, last + 1) if at != lead]
        return names[0] if len(names) == 1 else "every other body"


def _body(player: Player) -> Body:
    if player.body is None:
        raise RuntimeError(f"{player.name} cannot move")
    return player.body


def _rest(player: Player) -> Motion:
    if player.figure is None:
        raise RuntimeError(f"{player.name} is not drawn")
    model = player.figure.model
    at = model.qpos0 if player.body is None else player.body.still.position
    return posed(model, np.asarray(at)[None])
