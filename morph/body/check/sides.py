"""Left and right: which parts are twins, and the plane between them."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from morph.arrays import Array

WORDS = (("left", "right"), ("l", "r"), ("fl", "fr"), ("hl", "hr"), ("rl", "rr"), ("bl", "br"))
FRONT = (("ml", "mr"), ("lf", "rf"), ("lh", "rh"), ("lb", "rb"), ("lm", "rm"), ("lr", "rr"))
TWINS = (*WORDS, *FRONT)
"""Words for the left side, each with the one for the right."""

TOKEN = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^A-Za-z\d]+")
"""A name's parts: words, capitals, numbers, and what separates them."""


def slide(normal: Array, vector: Array) -> Array:
    """Return the mirror image of an offset or a direction of sliding, shape (3,)."""
    image: Array = vector - 2 * (vector @ normal) * normal
    return image


def turn(normal: Array, axis: Array) -> Array:
    """Return the axis about which a mirror image turns, shape (3,).

    An axis of rotation is an axial vector: its part along the normal stays, and
    the rest is turned over.
    """
    image: Array = 2 * (axis @ normal) * normal - axis
    return image


def twins(names: Iterable[str]) -> list[tuple[str, str]]:
    """Return the names that differ only in a word for left and right, left ones first."""
    known = list(names)
    there = set(known)
    pairs = []
    for name in known:
        other = next((one for one in _others(name) if one in there and one != name), None)
        if other is not None:
            pairs.append((name, other))
    return pairs


def _others(name: str) -> Iterable[str]:
    tokens = TOKEN.findall(name)
    for at, token in enumerate(tokens):
        for left, right in TWINS:
            if token.lower() == left:
                yield "".join([*tokens[:at], _like(right, token), *tokens[at + 1 :]])
    # A letter that starts a name, as in LHipPitch or lhip, is no token of its own.
    if name[:1] in "lL":
        yield ("r" if name[0] == "l" else "R") + name[1:]


def _like(word: str, token: str) -> str:
    if token.isupper():
        return word.upper()
    return word.capitalize() if token[0].isupper() else word


def normal_between(left: Array, right: Array) -> Array | None:
    """Return the direction across the plane that twins are mirrored at, from right to left.

    Args:
        left: Offsets of joints from their parents, in the world's axes, shape (n, 3).
        right: Those of their twins, shape (n, 3).

    Returns:
        A unit vector, shape (3,), on which most pairs agree; None if there is none.
    """
    across = left - right
    length = np.linalg.norm(across, axis=1)
    apart = length > 1e-3
    if not apart.any():
        return None
    # Each pair has one vote for the direction in which it is apart.
    units = across[apart] / length[apart, None]
    votes = (np.abs(units @ units.T) > 0.99).sum(axis=1)
    chosen = np.abs(units @ units[votes.argmax()]) > 0.99
    if chosen.sum() < 0.5 * apart.sum():
        return None
    weights = np.sign(units[chosen] @ units[votes.argmax()]) * length[apart][chosen]
    normal: Array = (units[chosen] * weights[:, None]).sum(axis=0)
    # Left is where the widest pairs have it.
    return normal / np.linalg.norm(normal) if np.any(normal) else None
