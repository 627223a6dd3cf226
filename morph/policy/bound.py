"""How a policy keeps its commands between their bounds: it clips or squashes them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.errors import PolicyError
from morph.policy.policy import UNLIMITED, Action


def sine(x: Array) -> Array:
    """Return (9 sin x + sin 3x) / 8, between -1 and 1.

    Source: Deisenroth, Fox and Rasmussen 2015, IEEE TPAMI 37(2), section 4.1; with
    sin 3x = 3 sin x - 4 sin^3 x it is (3 s - s^3) / 2 for s = sin x, of one sine.
    """
    s = np.sin(x)
    return np.asarray(s * (1.5 - 0.5 * s * s))


SQUASHES: dict[str, Callable[[Array], Array] | None] = {"clip": None, "sine": sine, "tanh": np.tanh}
"""What keeps commands within bounds: nothing before they are clipped, or a smooth function."""


def limits(action: tuple[Action, ...], margin: float = 0.0) -> tuple[Array, Array]:
    """Return the least and the greatest command of each action, shape (actions,) each.

    With a margin they are that share of the range nearer to its middle. A plan that is made
    within such limits leaves its feedback room on either side: at the bound itself half of
    every correction would be clipped away.

    Args:
        action: The actions.
        margin: From 0, the bounds themselves, to less than 1.

    Raises:
        PolicyError: The margin is none.
    """
    if not 0.0 <= margin < 1.0:
        raise PolicyError(
            f"a margin of {margin:g} is out of range, 0 to below 1",
            where="the limits of a plan",
            fix="take 0.1",
        )
    low, high = np.array([(each.low, each.high) for each in action], dtype=float).reshape(-1, 2).T
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    if margin == 0.0:
        return low, high
    return middle - (1.0 - margin) * half, middle + (1.0 - margin) * half


@dataclass(frozen=True, kw_only=True, eq=False)
class Bound:
    """What makes commands out of numbers of any size."""

    how: str
    """One of `SQUASHES`."""
    low: Array
    """The least commands, shape (actions,)."""
    high: Array
    """The greatest commands, shape (actions,)."""

    def __call__(self, x: Array) -> Array:
        """Return commands, shape (..., actions), of numbers of the same shape.

        Clipped they are in the unit of the command; squashed, 0 is the middle of the range
        and the unit is half of it.
        """
        squash = SQUASHES[self.how]
        if squash is not None:
            x = (self.low + self.high) / 2.0 + (self.high - self.low) / 2.0 * squash(x)
        # Rounding may leave a squashed command a last digit beyond its bound.
        return np.asarray(np.minimum(np.maximum(x, self.low), self.high))


def bound_of(action: tuple[Action, ...], how: str, *, where: str) -> Bound:
    """Return what bounds a policy's commands.

    Raises:
        PolicyError: There is no such way, or it squashes what has no bounds.
    """
    if how not in SQUASHES:
        raise PolicyError(
            f"its bound is {how!r}", where=where, fix=f"use one of {', '.join(SQUASHES)}"
        )
    free = [each.actuator for each in action if each.high >= UNLIMITED or each.low <= -UNLIMITED]
    if how != "clip" and free:
        raise PolicyError(
            f"nothing limits {', '.join(free)}, and a squashed command fills its whole range",
            where=where,
            fix='give its action the bounds that you mean, or take bound="clip"',
        )
    low, high = limits(action)
    return Bound(how=how, low=low, high=high)
