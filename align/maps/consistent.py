"""Maps that agree with how both bodies move: Levenberg and Marquardt's rule on transitions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from morph.alignment.arrays import Array, Integers
from morph.alignment.maps.feature_warping import InvertibleWarp

Moves = Callable[[Array, Array], tuple[Array, Array, Array]]
"""From states (rows, n) and commands (rows, k), in spreads, to changes and their slopes by both."""

SLIGHT = 1e-6
"""How strongly a number of an affine part is held to 0, where nothing else says what it is."""

LEAST_SHARE = 0.03
"""A number that is foreseen ever better than the rest counts no more than 1 over this of it."""

LEAST_GAIN = 1e-4
"""A round that gains less, as a share of what is off, is the last."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ScaledTransitions:
    """A target's transitions, every number in its spread about its mean."""

    before: Array
    """t, shape (rows, m)."""
    command: Array
    """a, shape (rows, k_t)."""
    after: Array
    """t', shape (rows, m)."""

    @property
    def plain(self) -> Array:
        """What errors are multiplied by at first, shape (2, m): 1 over spreads of changes, and 1.

        The first row is for what is foreseen, the second for what is only seen again.
        """
        change: Array = (self.after - self.before).std(axis=0)
        return np.stack([1.0 / np.maximum(change, 1e-6), np.ones_like(change)])

    def rows(self, which: Integers) -> ScaledTransitions:
        """Return some of them."""
        parts = (self.before[which], self.command[which], self.after[which])
        return ScaledTransitions(before=parts[0], command=parts[1], after=parts[2])


@dataclass(frozen=True, kw_only=True, eq=False)
class Guess:
    """x = S z(t) + s, u = R z_a(a) + r, and back z = L x + b; all in spreads."""

    S: Array
    """Shape (n, m)."""
    s: Array
    """Shape (n,)."""
    R: Array
    """Shape (k, k_t)."""
    r: Array
    """Shape (k,)."""
    L: Array
    """Shape (m, n)."""
    b: Array
    """Shape (m,)."""
    states: InvertibleWarp
    """z."""
    commands: InvertibleWarp
    """z_a."""

    @property
    def affine(self) -> tuple[Array, ...]:
        """S, s, R, r, L and b."""
        return self.S, self.s, self.R, self.r, self.L, self.b

    @property
    def vector(self) -> Array:
        """All numbers one after another."""
        flat = [part.ravel() for part in self.affine]
        return np.concatenate([*flat, self.states.parameters, self.commands.parameters])

    def at(self, vector: Array) -> Guess:
        """Return the guess with other numbers."""
        parts, begins = [], 0
        for like in self.affine:
            parts.append(vector[begins : begins + like.size].reshape(like.shape))
            begins += like.size
        ends = begins + len(self.states.parameters)
        S, s, R, r, L, b = parts
        states, commands = self.states.at(vector[begins:ends]), self.commands.at(vector[ends:])
        return Guess(S=S, s=s, R=R, r=r, L=L, b=b, states=states, commands=commands)


@dataclass(frozen=True, kw_only=True, eq=False)
class MapGuess:
    """A guess, and how far it is from the transitions."""

    guess: Guess
    """The map."""
    loss: float
    """Mean square of all that is off, in spreads of changes and of states, and what holds it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Agreement:
    """How far a guess is from how a target was seen to move, and its slopes by all numbers.

    The next state as the target would read it, z^-1(z(t) + L (f(S z + s, R z_a + r) - (S z + s))),
    is compared with t', and z^-1(L (S z + s) + b) with t. Both are errors of the target's own
    readings: a map that sends all states to one, where a source's dynamics agree with anything,
    foresees nothing there and is no solution.
    """

    seen: ScaledTransitions
    """The target's transitions."""
    moves: Moves
    """How the source moves."""
    weight: Array
    """What errors are multiplied by, shape (2, m); as `ScaledTransitions.plain`."""

    def weighed(self, guess: Guess) -> Agreement:
        """Return this with every number weighed by how well a guess foresees it.

        Readings that are mostly noise, as small steps of a place are, then count less than those
        that are not. The mean square of all that is off stays what it was.

        Source: Aitken 1936, Proc. R. Soc. Edinburgh 55 (weights by the inverse of variances).
        """
        rows, m = self.seen.before.shape
        off = self.errors(guess)[0].reshape(2, rows, m)
        size = np.sqrt(np.square(off).mean(axis=1))
        whole = float(np.sqrt(np.square(size).mean()))
        return replace(self, weight=self.weight * whole / np.maximum(size, LEAST_SHARE * whole))

    def errors(self, guess: Guess) -> tuple[Array, Any]:
        """Return what is off, shape (2 rows m,), and what the slopes are made of."""
        seen = self.seen
        z, command = guess.states.value(seen.before), guess.commands.value(seen.command)
        x = z @ guess.S.T + guess.s
        move, by_x, by_u = self.moves(x, command @ guess.R.T + guess.r)
        next_t = guess.states.back(z + move @ guess.L.T)
        same_t = guess.states.back(x @ guess.L.T + guess.b)
        ahead, again = self.weight
        off = [((next_t - seen.after) * ahead).ravel(), ((same_t - seen.before) * again).ravel()]
        return np.concatenate(off), (z, command, x, move, by_x, by_u, next_t, same_t)

    def slopes(self, guess: Guess, at: Any) -> Array:
        """Return the slopes of what is off by `guess.vector`, shape (2 rows m, numbers)."""
        z, command, x, move, by_x, by_u, next_t, same_t = at
        (rows, m), n, k = z.shape, len(guess.s), len(guess.r)
        one = np.eye(m)
        by_z = guess.states.slope(self.seen.before)
        by_told = guess.commands.slope(self.seen.command)
        Lx, Lu = guess.L @ by_x, guess.L @ by_u
        ahead = [
            _outer(Lx, z), Lx, _outer(Lu, command), Lu, _outer(one, move), np.zeros((rows, m, m)),
            Lx @ guess.S @ by_z + by_z - guess.states.slope(next_t), Lu @ guess.R @ by_told,
        ]  # fmt: skip
        Lz = np.broadcast_to(guess.L, (rows, m, n))
        again = [
            _outer(Lz, z), Lz, np.zeros((rows, m, k * command.shape[1])), np.zeros((rows, m, k)),
            _outer(one, x), np.broadcast_to(one, (rows, m, m)),
            guess.L @ guess.S @ by_z - guess.states.slope(same_t),
            np.zeros((rows, m, by_told.shape[2])),
        ]  # fmt: skip
        J = [
            np.linalg.solve(guess.states.steep(t), np.concatenate(parts, axis=2))
            for t, parts in ((next_t, ahead), (same_t, again))
        ]
        weighed = [weight[:, None] * each for weight, each in zip(self.weight, J, strict=True)]
        return np.concatenate([each.reshape(rows * m, -1) for each in weighed])


def descended(
    guess: Guess, agree: Agreement, *, rounds: int, hold: float, gain: float = LEAST_GAIN
) -> MapGuess:
    """Return the guess to which the rule leads from a guess.

    Source: Marquardt 1963, J. SIAM 11(2).

    Args:
        guess: Where it begins.
        agree: What is to become small.
        rounds: At most so many.
        hold: How strongly parameters of curves and networks are held to 0.
        gain: A round that gains less, as a share of what is off, is the last.
    """
    vector = guess.vector
    bends = len(guess.states.parameters) + len(guess.commands.parameters)
    prior = np.full(len(vector), SLIGHT)
    prior[len(vector) - bends :] = hold
    damping = 1e-2
    # A step too far may overflow; it is then not taken.
    with np.errstate(all="ignore"):
        off, at = agree.errors(guess)
        loss = float(np.square(off).mean()) + float(prior @ vector**2)
        for _ in range(rounds):
            J = agree.slopes(guess, at)
            H = J.T @ J / len(off) + np.diag(prior)
            slope = J.T @ off / len(off) + prior * guess.vector
            if not (np.isfinite(H).all() and np.isfinite(slope).all()):
                break
            before = loss
            for _ in range(6):
                step = np.linalg.solve(H + damping * np.diag(np.diag(H)), slope)
                trial = guess.at(guess.vector - step)
                trial_off, trial_at = agree.errors(trial)
                loss = float(np.square(trial_off).mean()) + float(prior @ trial.vector**2)
                if loss < before:
                    break
                damping *= 5.0
            if not loss < before:
                return MapGuess(guess=guess, loss=before)
            guess, off, at = trial, trial_off, trial_at
            damping = max(damping / 5.0, 1e-7)
            if before - loss < gain * before:
                break
    return MapGuess(guess=guess, loss=loss)


def _outer(law: Array, number: Array) -> Array:
    """Return the slopes by a matrix M of `law (M number)`, shape (rows, m, size of M)."""
    law = np.broadcast_to(law, (len(number), *law.shape[-2:]))
    slopes = law[:, :, :, None] * number[:, None, None, :]
    return np.asarray(slopes.reshape(*law.shape[:2], -1))
