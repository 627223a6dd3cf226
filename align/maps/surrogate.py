"""A simulator in a formula: a cubic in states and commands, fast and with its slopes."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import SamplesError
from morph.alignment.samples import Step, Transitions

ASKED = 2400
"""How many steps the simulator is asked for."""

WIDER = 1.3
"""How far beyond the source's own samples these begin, a factor of their spread."""

LEAST_SPREAD = 1e-9
"""Less spread is none."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Surrogate:
    """How a source moves, x' - x = W (h h h), h = (1, x, u), all about the middle in spreads.

    A map is sought from many starts, each of which asks for the slopes of a simulator at every
    transition many times over; the cubic gives them at the cost of two products of matrices.
    """

    middle: Array
    """Of the states, shape (n,)."""
    spread: Array
    """Of the states, shape (n,)."""
    command_middle: Array
    """Of the commands, shape (k,)."""
    command_spread: Array
    """Of the commands, shape (k,)."""
    tensor: Array
    """W, symmetric in its first three axes, shape (1 + n + k, 1 + n + k, 1 + n + k, n)."""
    missed: float
    """Share of the squared changes, each in its spread, that it misses at steps held out."""

    def moves(self, x: Array, u: Array) -> tuple[Array, Array, Array]:
        """Return changes (m, n) and their slopes by x (m, n, n) and by u (m, n, k), in spreads."""
        h = np.concatenate([np.ones((len(x), 1)), x, u], axis=1)
        d, n = h.shape[1], x.shape[1]
        square = (h[:, :, None] * h[:, None, :]).reshape(len(h), -1)
        slope = (square @ self.tensor.reshape(d * d, d * n)).reshape(-1, d, n)
        move = np.einsum("mi,min->mn", h, slope)
        slope = 3.0 * np.swapaxes(slope[:, 1:], 1, 2)
        return move, slope[:, :, :n], slope[:, :, n:]


def surrogate(source: Transitions, step: Step, rng: np.random.Generator) -> Surrogate:
    """Return the cubic that moves most like a simulator where its transitions lie, and around.

    Args:
        source: What the source did: where the steps that are asked for begin.
        step: The source's simulator.
        rng: The chance of these starts.

    Raises:
        SamplesError: The source hardly moved, or its simulator gives no finite states.
    """
    middle, spread = source.state.mean(axis=0), source.state.std(axis=0)
    low, wide = source.command.mean(axis=0), source.command.std(axis=0)
    if not (spread.min() > LEAST_SPREAD and wide.min() > LEAST_SPREAD):
        raise SamplesError(
            "a state or a command of the source never changed",
            where="transitions of the source",
            fix="move every joint by random commands on every actuator",
        )
    place = source.state[rng.integers(len(source.state), size=ASKED)] - middle
    command = source.command[rng.integers(len(source.command), size=ASKED)] - low
    # Numbers that were seen together are taken apart by chance, so that the fit knows of each.
    x = WIDER * (place / spread + 0.3 * rng.standard_normal(place.shape))
    u = WIDER * command / wide
    after = np.asarray(step(middle + spread * x, low + wide * u))
    fine = np.isfinite(after).all(axis=1)
    move = (after - middle) / spread - x
    if fine.mean() < 0.9:
        raise SamplesError(
            f"the simulator lost {int((~fine).sum())} of {ASKED} steps",
            where="the source's simulator",
            fix="give transitions among which it is stable",
        )
    h = np.concatenate([np.ones((ASKED, 1)), x, u], axis=1)[fine]
    return _fitted(h, move[fine], middle, spread, low, wide)


def _fitted(
    h: Array, move: Array, middle: Array, spread: Array, low: Array, wide: Array
) -> Surrogate:
    d, n = h.shape[1], move.shape[1]
    index = np.array(list(combinations_with_replacement(range(d), 3)))
    columns = h[:, index[:, 0]] * h[:, index[:, 1]] * h[:, index[:, 2]]
    kept = 4 * len(h) // 5
    ridge = np.sqrt(1e-4) * np.eye(columns.shape[1])
    normal = columns[:kept].T @ columns[:kept] + ridge.T @ ridge
    weight = np.linalg.solve(normal, columns[:kept].T @ move[:kept])
    off = (columns[kept:] @ weight - move[kept:]) / np.maximum(move.std(axis=0), LEAST_SPREAD)
    tensor = np.zeros((d, d, d, n))
    for (a, b, c), row in zip(index, weight, strict=True):
        places = {(a, b, c), (a, c, b), (b, a, c), (b, c, a), (c, a, b), (c, b, a)}
        for place in places:
            tensor[place] = row / len(places)
    return Surrogate(
        middle=middle,
        spread=spread,
        command_middle=low,
        command_spread=wide,
        tensor=tensor,
        missed=float(np.square(off).mean()),
    )
