"""Where each servo belongs in a body, learned from what the trunk does as it swings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.errors import TransferError

LAGS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5)
"""How late a servo may come after what it is told, s: what is tried."""

CLEAR = 3.0
"""How many standard deviations of its noise a response must have to tell its sign."""

V, W = slice(0, 3), slice(3, 6)
"""The speeds and the turning rates of a twist."""


@dataclass(frozen=True, kw_only=True)
class Limb:
    """Where one servo belongs."""

    place: float
    """From 0 in front to 1 at the rear."""
    side: float
    """0 left, 1 right; 0.5 in the middle."""
    sense: float
    """1 or -1: which way it is told to do what the others do; 0 if it rests."""
    sure: bool
    """Whether the response is clear of its noise."""
    role: str = ""
    """`swing` or `lift` of a leg; empty in a swimmer."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Responses:
    """How far trunk and far end go as each servo moves: place = response * its angle."""

    trunk: Array
    """Of the trunk, m and rad per rad of the servo, shape (servos, 6)."""
    end: Array
    """The same of the far end, shape (servos, 6)."""
    error: Array
    """Standard error of the trunk's responses, shape (servos, 6)."""
    late: float
    """How late the body comes after the command, s."""


def responses(seen: Transitions, *, period: float) -> Responses:
    """Return the responses that transitions of single servos show, by least squares.

    p_t = c w_t, where p is the twist summed since the run began and w the command after a lag
    of first order, the one that explains most. Sums, because a bell that is late is still a
    bell of the same sign, and a twist that is late is not.

    Args:
        seen: Of `Mover.transitions`: a run for each servo, one after another, all as long.
        period: Control period, s.

    Raises:
        TransferError: There is no run for each servo, or nothing moved.
    """
    size = seen.command.shape[1]
    slot = len(seen.command) // size
    command = np.array([seen.command[i * slot : (i + 1) * slot, i] for i in range(size)])
    command = command - command[:, :1]
    if slot * size != len(seen.command) or not (np.abs(command).max(axis=1) > 0.0).all():
        raise TransferError(
            f"{len(seen.command)} transitions hold no run in which each of {size} servos swings",
            where="responses of a body",
            fix="take those of Mover.transitions",
        )
    # What came before the bells, such as settling on the floor, is no response to them.
    first = int((np.abs(command).max(axis=0) > 0.0).argmax())
    command, slot = command[:, first:], slot - first
    moved = period * np.cumsum(seen.after.reshape(size, first + slot, -1)[:, first:], axis=1)
    tried = [_fitted(command, moved, late, period) for late in LAGS]
    best = min(range(len(LAGS)), key=lambda each: float(tried[each][1].sum()))
    c, left, spread = tried[best]
    error = np.sqrt(left[:, :6] / slot) / spread[:, None]
    return Responses(trunk=c[:, :6], end=c[:, 6:], error=error, late=LAGS[best])


def _fitted(command: Array, moved: Array, late: float, period: float) -> tuple[Array, Array, Array]:
    follows, now = np.empty_like(command), np.zeros(len(command))
    for at in range(command.shape[1]):
        now = now + period / (late + period) * (command[:, at] - now)
        follows[:, at] = now
    power = (follows**2).sum(axis=1)
    c = np.einsum("it,itk->ik", follows, moved) / power[:, None]
    left = ((moved - follows[..., None] * c[:, None]) ** 2).sum(axis=1)
    return c, left, np.sqrt(power)


def limbs(result: Responses) -> tuple[Limb, ...]:
    """Return where each servo of a swimmer belongs, by what it does to trunk and far end.

    Servos that bend the body, or beat beside it, in one plane make the stroke: sideways (v_y,
    w_z) or, if more are clear there, up and down (v_z, -w_y). Of a chain, the trunk turns most
    by joints in front and the far end by those at the rear, one against the other, so that the
    shares tell the place and the difference the sense, whichever way a joint was mounted. Of
    a body with limbs on a hull, w over v is the lever, positive in front, v the sense, and the
    roll the side.

    Raises:
        TransferError: No two servos move the trunk across.
    """
    chain = bool(np.abs(result.end - result.trunk).max() > 1e-9)
    across = [_plane(result, axis) for axis in (1, 2)]
    # Of a chain what bends tells more than what the trunk does, which is little at the rear.
    strong = [np.abs(tail - w) if chain else np.hypot(v, w) for v, w, tail in across]
    both = np.array(strong)
    clear = both > CLEAR * np.stack([result.error[:, 5], result.error[:, 4]])
    mine = [clear[axis] & (both[axis] >= both[1 - axis]) for axis in (0, 1)]
    # The plane with more servos, and of two alike the one in which they do more.
    plane = max((0, 1), key=lambda each: (int(mine[each].sum()), float(both[each].sum())))
    chosen = mine[plane]
    if chosen.sum() < 2:
        raise TransferError(
            f"{int(chosen.sum())} of {len(chosen)} servos move the trunk across",
            where="limbs of a body",
            fix="give transitions of wider swings, or with less noise",
        )
    v, w, tail = across[plane]
    roll = result.trunk[:, 3]
    beside = not chain and bool((np.abs(roll) > np.abs(w))[chosen].all())
    side = np.where(roll * np.sign(v) > 0.0, 0.0, 1.0) if beside else np.full(len(v), 0.5)
    key = np.abs(tail) / (np.abs(tail) + np.abs(w) + 1e-12) if chain else -w / v
    sense = np.sign(tail - w) if chain else np.sign(v)
    return tuple(
        Limb(
            place=_rank(key, at, chosen & (side == side[at])) if chosen[at] else 0.5,
            side=float(side[at]),
            sense=float(sense[at]) if chosen[at] else 0.0,
            sure=bool(clear[plane, at] or not chosen[at]),
        )
        for at in range(len(v))
    )


def _plane(result: Responses, axis: int) -> tuple[Array, Array, Array]:
    turning = (5, 1.0) if axis == 1 else (4, -1.0)
    at, sign = turning
    return result.trunk[:, axis], sign * result.trunk[:, at], sign * result.end[:, at]


def _rank(key: Array, at: int, among: Array) -> float:
    mine = np.sort(key[among])
    # In lengths of the body: two hinges are a third of it apart, and none is at an end.
    return float((np.searchsorted(mine, key[at]) + 1) / (len(mine) + 1))
