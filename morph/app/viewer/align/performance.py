"""How the bodies of a chain move together: one leads, the others are where the maps put them."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from morph.app.viewer.align.chain_bodies import ChainPlayer
from morph.app.viewer.align.joint_turns import moving, rest, turns
from morph.app.viewer.align.laws import kept, law
from morph.app.viewer.align.lines import called
from morph.app.viewer.align.maps import maps_of
from morph.app.viewer.align.transfer_record import Story
from morph.app.viewer.content import Moment
from morph.app.viewer.motion import MotionFrames, motion
from morph.arrays import Array

PARTS, TARGET, SOURCE = "parts in turn", "the target leads", "the source leads"
"""What may move."""

LARGER = (1.0, 2.0, 5.0, 10.0, 20.0)
"""By how much motions may be enlarged, so that they are seen."""

VISIBLE = 0.35
"""Up to how large the largest of them may then be, rad or m."""


FAR = 100.0
"""Beyond so many metres or radians a body has come apart, and nobody looks any more."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene:
    """How the bodies of a stretch of the chain move."""

    motions: tuple[MotionFrames, ...]
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
        ViewError: A map or a law is spoilt.
    """

    def __init__(self, story: Story, players: Sequence[ChainPlayer], seed: int = 0) -> None:
        """Read the maps, and look whether the laws can be read."""
        hops = zip(story.hops, pairwise(players), strict=True)
        self.story = replace(story, hops=tuple(called(hop, *pair) for hop, pair in hops))
        self.players, self._seed = tuple(players), seed
        self.maps = maps_of(story, players)
        for at, player in enumerate(self.players):
            # What is spoilt is told now, not when somebody chooses it.
            _ = None if player.body is None else kept(story, player.body, at)
        self._made: dict[tuple[int, int, str, bool], Scene] = {}
        self._lock = threading.Lock()

    def ways(self, first: int, last: int) -> tuple[str, ...]:
        """Return what may move between two bodies of the chain, what shows most first."""
        players = self.players[first : last + 1]
        results = []
        if players[0].whole:
            results.append(PARTS)
        results += [TARGET] if players[-1].body is not None else []
        results += [SOURCE] if players[0].body is not None else []
        if not all(each.whole for each in players) and TARGET in results:
            results.sort(key=lambda each: each != TARGET)
        return tuple(results)

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
            return Scene(motions=tuple(rest(each) for each in self.players if each.figure))
        lead = last if way == TARGET else first
        moments: tuple[Moment, ...] = ()
        if way == PARTS:
            times, state, moments, statement = turns(self.players[first], self.story.hops[first])
            ran: dict[int, Array] = {}
        else:
            times, state, position, statement = self._run(lead)
            ran = {lead: position}
        states = self._carried(state, first, last, lead)
        until = _until(states.values())
        times, states = times[:until], {at: each[:until] for at, each in states.items()}
        scale = self._scale(states, ran) if large and way != PARTS else 1.0
        others = self._others(states, lead)
        notes = [f"{statement}; {others} shows what the map makes of it" if others else statement]
        notes += self._still(first, last, states, ran)
        if scale > 1.0:
            notes.append(f"Motions are drawn {scale:g} times as large as they are")
        motions = (
            _motion(player, times, scale, states.get(at), ran.get(at))
            for at, player in enumerate(self.players)
            if player.figure is not None
        )
        return Scene(motions=tuple(motions), moments=moments, notes=tuple(notes))

    def _run(self, lead: int) -> tuple[Array, Array, Array, str]:
        """Return times, what is seen, the joints, and in words what moves a body that runs."""
        body = moving(self.players[lead])
        given, words = law(self.story, self.players, self.maps, lead)
        with np.errstate(over="ignore", invalid="ignore"):
            moved = body.run(given, rows=1, rng=np.random.default_rng([self._seed, 7]))
        q, v = moved.position[0], moved.velocity[0]
        lost = np.flatnonzero(~np.isfinite(q).all(axis=1))
        fine = int(lost[0]) if len(lost) else len(q)
        push = body.task.start.push
        began = "" if push is None else f", pushed at {push.link} with {abs(push.impulse[0]):g} N s"
        seen = body.seen(body.state(q[:fine], v[:fine]))
        return moved.time[:fine], seen, q[:fine], f"{words}{began}"

    def _carried(self, state: Array, first: int, last: int, lead: int) -> dict[int, Array]:
        """Return what the maps make of a body's states all along the stretch."""
        results = {lead: state}
        for at in range(lead, first, -1):
            body_map = self.maps[at - 1]
            if body_map is None:
                break
            results[at - 1] = body_map.state(results[at])
        for at in range(lead, last):
            body_map = self.maps[at]
            if body_map is None:
                break
            results[at + 1] = body_map.state_back(results[at])
        return results

    def _scale(self, states: dict[int, Array], ran: dict[int, Array]) -> float:
        """Return by how much motions are enlarged: not at all if a body can be shown as is only."""
        if any(not self.players[at].whole for at in ran):
            return 1.0
        shown = [
            np.abs(each[:, : each.shape[1] // 2]).max()
            for at, each in states.items()
            if self.players[at].whole and len(each)
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
            if player.whole:
                notes.append(f"{player.name} stands at rest: no map leads to it")
                continue
            notes.append(
                f"{player.name} stands at rest: it is seen by {player.body.size // 2} readings, "
                "and these do not tell where every joint is"
            )
        return notes

    def _others(self, states: dict[int, Array], lead: int) -> str:
        """Return which bodies are where a map puts them, in words; empty if none is."""
        names = [
            self.players[at].name for at in sorted(states) if at != lead and self.players[at].whole
        ]
        return "every other body" if len(names) > 1 else "".join(names)


def _until(states: Iterable[Array]) -> int:
    """Return how many samples pass before a body is nowhere any more, at least one."""
    places = (each[:, : each.shape[1] // 2] for each in states)
    near = [np.abs(np.nan_to_num(each, nan=np.inf)).max(axis=1) < FAR for each in places]
    lost = np.flatnonzero(~np.all(near, axis=0))
    return max(1, int(lost[0])) if len(lost) else len(near[0])


def _motion(
    player: ChainPlayer, times: Array, scale: float, state: Array | None, ran: Array | None
) -> MotionFrames:
    """Return how a body moves by its states, or by its joints where these tell more."""
    if player.figure is None or player.body is None or not len(times):
        return rest(player)
    model = player.figure.model
    if player.whole and state is not None:
        return motion(model, times, player.body.place(scale * state)[0])
    return rest(player) if ran is None else motion(model, times, ran[: len(times)])
