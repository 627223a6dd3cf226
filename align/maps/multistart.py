"""Multi-start search for a consistent map: on a cubic surrogate first, then on the simulator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError, SamplesError, SettingError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.bent_map import BentMap
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.consistent import (
    Agreement,
    Guess,
    MapGuess,
    Moves,
    ScaledTransitions,
    descended,
)
from morph.alignment.maps.feature_warping import InvertibleWarp
from morph.alignment.maps.initial_guess import beginnings
from morph.alignment.maps.surrogate import LEAST_SPREAD, Surrogate, surrogate
from morph.alignment.samples import Step, Transitions
from morph.alignment.states import change

NEAR = 1e-4
"""Length of a finite difference of the simulator, in spreads."""

SAME = 0.005
"""Two starts whose losses differ by a smaller share have come to the same map."""

HEAT_ROUNDS = 4
"""Rounds of a finalist before it is compared."""

ROUGH = 1e-3
"""A start's descent ends as soon as a round gains less than this share."""

FAINTEST = 1e-5
"""A command whose spread moves nothing by more than this, in spreads, does nothing."""

WORST = 1e6
"""A map whose greatest singular value is so many times its least has no inverse."""


@dataclass(frozen=True, kw_only=True)
class FitBudget:
    """How long a consistent map is looked for."""

    starts: int = 32
    """So many maps are drawn to begin from."""
    rounds: int = 25
    """At most so many rounds of each descent."""
    candidates: int = 6
    """So many different affine maps are bent."""
    finalists: int = 4
    """And so many of these compared under the simulator itself."""
    heat: int = 100
    """On so many transitions; the best alone sees all of them."""

    def __post_init__(self) -> None:
        """Check the counts."""
        if min(vars(self).values()) < 1:
            raise SettingError(
                f"{self} has a count below 1",
                where="the search for a consistent map",
                fix="give counts of 1 or more",
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class Bends:
    """What straightens the numbers of a target, made for so many of them."""

    states: Callable[[int], InvertibleWarp] = field()
    """For the states."""
    commands: Callable[[int], InvertibleWarp] = field()
    """For the commands."""
    hold: float
    """How strongly their parameters are held to 0, where they do nothing."""


def consistent(
    given: MapData, rng: np.random.Generator, *, effort: FitBudget, bends: Bends | None, where: str
) -> BentMap:
    """Return the map under which the target moves as the source's simulator says.

    Args:
        given: Both bodies' transitions, and the source's simulator.
        rng: The chance of the starts.
        effort: How long it is looked for.
        bends: What straightens the target's numbers; None for an affine map.
        where: Who asks, for errors.

    Raises:
        MapError: There is no simulator, or what is found has no inverse.
        SamplesError: The target's transitions are too few or one of its numbers never changed.
    """
    if given.step is None:
        raise MapError("it is not given step", where=where, fix="give the source's simulator")
    source, target = given.source, given.target
    _check(source, target, where)
    middle, spread = target.state.mean(axis=0), target.state.std(axis=0)
    low, wide = target.command.mean(axis=0), target.command.std(axis=0)
    before = (target.state - middle) / spread
    seen = ScaledTransitions(
        before=before,
        command=(target.command - low) / wide,
        after=before + change(target.state, target.after, target.turns) / spread,
    )
    cubic = surrogate(source, given.step, rng)
    _check_heard(given.step, cubic, source, where)
    best = _best(
        _finalists(source, cubic, seen, rng, effort, bends), given.step, cubic, seen, effort, bends
    )
    return _unscaled(best.guess, cubic, (middle, spread, low, wide), where)


def _check(source: Transitions, target: Transitions, where: str) -> None:
    n, k = source.state.shape[1], source.command.shape[1]
    least = 2 * (n + k + 1)
    if len(target.state) < least or len(source.state) < least:
        raise SamplesError(
            f"there are {len(source.state)} transitions of the source and {len(target.state)} of "
            f"the target, where a linear model of the source has {n + k + 1} numbers a row",
            where=where,
            fix=f"give at least {least} of both",
        )
    for name, value in (("state", target.state), ("command", target.command)):
        still = np.flatnonzero(value.std(axis=0) <= LEAST_SPREAD)
        if len(still):
            raise SamplesError(
                f"number {still[0]} of the target's {name} never changed",
                where=where,
                fix="excite every joint and every actuator, or leave out what cannot move",
            )


def _check_heard(step: Step, cubic: Surrogate, source: Transitions, where: str) -> None:
    """Refuse a source with a command that does nothing: any map of it would agree."""
    after = step(source.state, source.command)
    for number, middle in enumerate(cubic.command_middle):
        command = source.command.copy()
        command[:, number] = middle
        if np.abs((step(source.state, command) - after) / cubic.spread).max() < FAINTEST:
            raise SamplesError(
                f"command {number} of the source moves nothing",
                where=where,
                fix="leave out commands that do nothing, or give larger ones",
            )


def _finalists(
    source: Transitions,
    cubic: Surrogate,
    seen: ScaledTransitions,
    rng: np.random.Generator,
    effort: FitBudget,
    bends: Bends | None,
) -> list[MapGuess]:
    """Return different maps that the starts came to under the cubic, the best first."""
    x = (source.state - cubic.middle) / cubic.spread
    u = (source.command - cubic.command_middle) / cubic.command_spread
    move = change(source.state, source.after, source.turns) / cubic.spread
    draws = beginnings(x, u, move, seen)
    agree = Agreement(seen=seen, moves=cubic.moves, weight=seen.plain)
    starts = (draws.drawn(rng) for _ in range(effort.starts))
    fits = [descended(g, agree, rounds=effort.rounds, hold=0.0, gain=ROUGH) for g in starts]
    fits.sort(key=lambda fit: fit.loss)
    if bends is None:
        return _different(fits, effort.finalists)
    m, command = seen.before.shape[1], seen.command.shape[1]
    bent = [
        replace(fit.guess, states=bends.states(m), commands=bends.commands(command))
        for fit in _different(fits, effort.candidates)
    ]
    fits = [descended(each, agree, rounds=effort.rounds, hold=bends.hold) for each in bent]
    return _different(sorted(fits, key=lambda fit: fit.loss), effort.finalists)


def _different(fits: list[MapGuess], count: int) -> list[MapGuess]:
    """Return the best of sorted fits, one of each loss: some that err alike are one map."""
    result = fits[:1]
    for fit in fits[1:]:
        if fit.loss > result[-1].loss * (1.0 + SAME) and len(result) < count:
            result.append(fit)
    return result


def _best(
    fits: list[MapGuess],
    step: Step,
    cubic: Surrogate,
    seen: ScaledTransitions,
    effort: FitBudget,
    bends: Bends | None,
) -> MapGuess:
    """Return the map that agrees best under the simulator, from where it agreed with the cubic."""
    exact, hold = _exact(step, cubic), 0.0 if bends is None else bends.hold
    # What the cubic cannot tell apart the simulator tells within a few rounds, on part of the data.
    heat = Agreement(seen=_part(seen, effort.heat), moves=exact, weight=seen.plain)
    trial = [descended(fit.guess, heat, rounds=HEAT_ROUNDS, hold=hold) for fit in fits]
    best = min(trial, key=lambda fit: fit.loss)
    agree = Agreement(seen=seen, moves=exact, weight=seen.plain)
    best = descended(best.guess, agree, rounds=effort.rounds, hold=hold)
    return descended(best.guess, agree.weighed(best.guess), rounds=effort.rounds, hold=hold)


def _part(seen: ScaledTransitions, count: int) -> ScaledTransitions:
    """Return so many transitions, evenly from all; all if there are no more."""
    rows = len(seen.before)
    return seen.rows(np.linspace(0, rows - 1, min(count, rows)).astype(np.int64))


def _exact(step: Step, cubic: Surrogate) -> Moves:
    """Return how the simulator itself moves, in spreads, with slopes by finite differences."""

    def moves(x: Array, u: Array) -> tuple[Array, Array, Array]:
        (rows, n), k = x.shape, u.shape[1]
        apart = NEAR * np.eye(n + k)
        many_x = np.concatenate([x, *(x + row for row in apart[:n, :n]), *[x] * k])
        many_u = np.concatenate([u, *[u] * n, *(u + row for row in apart[n:, n:])])
        after = step(
            cubic.middle + cubic.spread * many_x,
            cubic.command_middle + cubic.command_spread * many_u,
        )
        after = ((after - cubic.middle) / cubic.spread).reshape(1 + n + k, rows, n)
        slope = np.moveaxis((after[1:] - after[0]) / NEAR, 0, 2)
        return after[0] - x, slope[:, :, :n] - np.eye(n), slope[:, :, n:]

    return moves


def _unscaled(
    guess: Guess, cubic: Surrogate, about: tuple[Array, Array, Array, Array], where: str
) -> BentMap:
    """Return the map in the bodies' own units, its ways back made exact."""
    for name, law in (("states", guess.S), ("commands", guess.R)):
        sizes = np.linalg.svd(law, compute_uv=False)
        if not (np.isfinite(sizes).all() and sizes[0] < WORST * sizes[-1]):
            raise MapError(
                f"the map of {name} that agrees best has no inverse",
                where=where,
                fix="give more transitions, which excite every joint, or another source",
            )
    (n, m), (k, command) = guess.S.shape, guess.R.shape
    x_spread, u_spread = cubic.spread, cubic.command_spread
    S_back, R_back = np.linalg.pinv(guess.S), np.linalg.pinv(guess.R)
    # The learned way back, moved by the least that makes the way there undo it.
    L = guess.L - S_back @ (guess.S @ guess.L - np.eye(n)) if n <= m else S_back
    b = guess.b - S_back @ (guess.S @ guess.b + guess.s) if n <= m else -S_back @ guess.s
    middle, spread, low, wide = about
    affine = AffineMap(
        state_law=x_spread[:, None] * guess.S,
        state_shift=cubic.middle + x_spread * guess.s,
        lift_law=L / x_spread,
        lift_shift=b - L @ (cubic.middle / x_spread),
        action_law=R_back / u_spread,
        action_state=np.zeros((command, m)),
        action_shift=-R_back @ (guess.r + cubic.command_middle / u_spread),
        read_law=u_spread[:, None] * guess.R,
        read_state=np.zeros((k, m)),
        read_shift=cubic.command_middle + u_spread * guess.r,
    )
    return BentMap(
        affine=affine, states=guess.states, commands=guess.commands,
        middle=middle, spread=spread, command_middle=low, command_spread=wide,
    )  # fmt: skip
