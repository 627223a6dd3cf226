"""How good a map between two bodies is: its way there and back, and whether both move alike."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from morph.alignment.arrays import Array, Integers, Mask
from morph.alignment.errors import AlignError, SamplesError
from morph.alignment.maps.body_map import BodyMap, MapData, Mapper
from morph.alignment.samples import Step, Transitions


@dataclass(frozen=True, kw_only=True)
class Quality:
    """Figures of a map on transitions that it was not learned from; 0 is perfect."""

    round_trip: float
    """Root mean square of state(state_back(x)) - x, in the source's spreads."""
    command_round_trip: float
    """The same of a command of the source told to the target and read again."""
    one_step: float
    """Share of the squared changes of a step that the source's simulator does not foresee.

    Each number counts in the spread of its change; 1 is what foreseeing no change at all errs.
    """
    many_steps: float
    """The same over several steps in a row, of which only the first state was seen."""
    steps: int
    """How many those are; 1 if no transitions follow each other."""

    def numbers(self) -> Mapping[str, float]:
        """Return the figures by name, as `transfer.json` holds them."""
        return {name: float(value) for name, value in vars(self).items()}


def quality(
    body_map: BodyMap, source: Transitions, target: Transitions, step: Step, *, steps: int = 5
) -> Quality:
    """Return how good a map is.

    Args:
        body_map: The map.
        source: What the source did: where the round trips begin.
        target: What the target did, none of which the map was learned from.
        step: The source's simulator.
        steps: How many steps in a row are foreseen, where so many follow each other.

    Raises:
        SamplesError: The source never moved.
    """
    spread, command = source.state.std(axis=0), source.command.std(axis=0)
    if min(spread.max(initial=0.0), command.max(initial=0.0)) <= 0.0:
        raise SamplesError(
            "no state, or no command, of the source ever changed",
            where="the quality of a map",
            fix="give transitions in which it moves",
        )
    back = body_map.state_back(source.state)
    there = body_map.state(back) - source.state
    read = body_map.action_back(back, body_map.action(back, source.command)) - source.command
    starts, length = _runs(target, steps)
    return Quality(
        round_trip=_size(there, spread),
        command_round_trip=_size(read, command),
        one_step=_missed(body_map, target, step, np.arange(len(target.state)), 1),
        many_steps=_missed(body_map, target, step, starts, length),
        steps=length,
    )


def resampled(
    mapper: Mapper, given: MapData, rng: np.random.Generator, *, rounds: int = 5
) -> float:
    """Return how far maps of resampled transitions lie apart, in spreads of what they say.

    Transitions of the target are drawn again with putting back, and the map is learned anew from
    each draw. The figure is the standard deviation, over the draws, of the source's state that a
    target's state is taken for, root mean square over both, in spreads over the target's states.
    1 and more: the data do not fix the map. A body that is its own mirror image has two maps that
    are equally right, and between them this figure is large as well.

    Source: Efron 1979, Annals of Statistics 7(1).

    Raises:
        SamplesError: Fewer than two draws allow a map.
    """
    seen, count = given.target, len(given.target.state)
    results = []
    for _ in range(rounds):
        which = rng.integers(count, size=count)
        again = Transitions(
            state=seen.state[which],
            command=seen.command[which],
            after=seen.after[which],
            turns=seen.turns,
        )
        try:
            one = mapper.fit(replace(given, target=again), rng)
        except AlignError:
            continue
        results.append(one.state(seen.state))
    if len(results) < 2:
        raise SamplesError(
            f"{len(results)} of {rounds} draws of the transitions allow a map",
            where="the bootstrap of a map",
            fix="give more transitions",
        )
    predictions = np.stack(results)
    spread = np.maximum(predictions.std(axis=1).mean(axis=0), 1e-12)
    return _size(predictions.std(axis=0), spread)


def _size(off: Array, spread: Array) -> float:
    fine = spread > 0.0
    return float(np.sqrt(np.square(off[:, fine] / spread[fine]).mean()))


def _runs(seen: Transitions, steps: int) -> tuple[Integers, int]:
    """Return where as many transitions as possible, at most `steps`, follow each other."""
    same: Mask = np.asarray(seen.state[1:] == seen.after[:-1], dtype=bool)
    follows: Mask = np.asarray(same.all(axis=1))
    for length in range(min(steps, len(follows) + 1), 1, -1):
        windows = np.lib.stride_tricks.sliding_window_view(follows, length - 1)
        starts = np.flatnonzero(windows.all(axis=1))
        if len(starts):
            return starts, length
    return np.arange(len(seen.state)), 1


def _missed(
    body_map: BodyMap, seen: Transitions, step: Step, starts: Integers, length: int
) -> float:
    x = body_map.state(seen.state[starts])
    begun = x
    for later in range(length):
        at = starts + later
        x = step(x, body_map.action_back(seen.state[at], seen.command[at]))
    after = body_map.state(seen.after[starts + length - 1])
    moved, off = after - begun, after - x
    spread = np.sqrt(np.square(moved).mean(axis=0))
    fine = spread > 0.0
    lost: Mask = np.asarray(~np.isfinite(off).all(axis=1))
    # A step that the simulator cannot make is foreseen no better than by standing still.
    off = np.where(lost[:, None], moved, off)
    return float(np.square(off[:, fine] / spread[fine]).mean()) if fine.any() else 1.0
