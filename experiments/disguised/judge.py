"""How much of a hidden map is found, up to what a body's own symmetries leave open."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from experiments.disguised.disguise import Bend, Disguise
from experiments.disguised.excited import Wild
from morph.arrays import JSON, Array, Mask

ALIKE = 1e-6
"""Steps that differ by less, in spreads, are the same."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Symmetries:
    """What may be done to a body's states and commands without its motion telling."""

    signs: tuple[tuple[Array, Array], ...]
    """Of states (n,) and commands (k,): a body that is its own mirror image has two."""
    shifts: Mask
    """Which numbers of a state may be moved: a cart does not feel where it is, shape (n,)."""


def symmetries(body: Wild, rng: np.random.Generator) -> Symmetries:
    """Return the signs and shifts that the body's simulator does not tell, by trying all."""
    x, u = body.starts(20, rng), body.commands(20, rng)
    after = body.step(x, u)
    spread = after.std(axis=0)

    def same(mine: Array, other: Array) -> bool:
        return bool((np.abs(mine - other) < ALIKE * spread).all())

    signs = []
    for joints in product((1.0, -1.0), repeat=body.joints):
        for told in product((1.0, -1.0), repeat=u.shape[1]):
            state, command = np.array(joints * 2), np.array(told)
            if same(body.step(state * x, command * u), state * after):
                signs.append((state, command))
    far = 0.3 * np.eye(2 * body.joints)
    shifts = [same(body.step(x + row, u), after + row) for row in far]
    return Symmetries(signs=tuple(signs), shifts=np.array(shifts))


@dataclass(frozen=True, kw_only=True, eq=False)
class Truth:
    """What a disguised body did, undisguised, at states that no map was learned from."""

    target: Array
    """y, shape (rows, m)."""
    told: Array
    """a, shape (rows, k_t)."""
    state: Array
    """x, shape (rows, n)."""
    command: Array
    """u, shape (rows, k)."""


def judged(said: tuple[Array, Array], truth: Truth, hidden: Disguise, free: Symmetries) -> JSON:
    """Return what a map got right: R2 of every number, parts and signs.

    Args:
        said: What the map says of the truth's target states and commands.
        truth: What they are.
        hidden: The disguise.
        free: What the body's symmetries leave open: the best of these counts.
    """
    found = [_under(signs, said, truth, hidden, free) for signs in free.signs]
    return max(found, key=lambda row: float(row["states"]) + float(row["commands"]))


def _under(
    signs: tuple[Array, Array],
    said: tuple[Array, Array],
    truth: Truth,
    hidden: Disguise,
    free: Symmetries,
) -> JSON:
    x, u = (sign * each for sign, each in zip(signs, said, strict=True))
    off, off_u = x - truth.state, u - truth.command
    off = off - np.where(free.shifts, off.mean(axis=0), 0.0)
    states = 1.0 - np.square(off).mean(axis=0) / truth.state.var(axis=0)
    commands = 1.0 - np.square(off_u).mean(axis=0) / truth.command.var(axis=0)
    parts = [*_parts(x, truth.target, hidden.states), *_parts(u, truth.told, hidden.commands)]
    return {
        "states": float(states.mean()),
        "commands": float(commands.mean()),
        "least": float(min(states.min(), commands.min())),
        "parts": float(np.mean(parts)),
        "whole": bool(all(parts)),
        "each": [*states.round(5).tolist(), *commands.round(5).tolist()],
    }


def _parts(said: Array, seen: Array, bend: Bend) -> list[bool]:
    """Return of every number that is not mixed whether it is taken for the right one and way."""
    found = []
    for row, number in zip(bend.mix, seen.T, strict=True):
        if np.count_nonzero(row) > 1:
            continue
        true = int(np.argmax(np.abs(row)))
        with np.errstate(invalid="ignore"):
            alike = np.array([np.corrcoef(each, number)[0, 1] for each in said.T])
        alike = np.nan_to_num(alike)
        guess = int(np.argmax(np.abs(alike)))
        found.append(bool(guess == true and alike[guess] * row[true] > 0.0))
    return found
