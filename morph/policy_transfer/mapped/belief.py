"""What is believed of a body's dynamics near rest: before it moved, and after."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.policy_transfer.body import Body

ROUNDS = 20
"""Rounds in which the evidence chooses how far to trust what was believed beforehand."""

SMALL = 1e-4
"""Variance of what places slip, beforehand, beside that of what speeds change."""

STEP = 1e-4
"""Distance of a finite difference."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearPosterior:
    """x' = A x + B u, from accelerations law (x, u) that are normally distributed.

    Places follow the mean of two speeds, and beside that a slip (x, u), also normal: a body that
    falls fast does not fall at a constant acceleration within a period.
    """

    law: Array
    """Most probable accelerations, shape (n/2, n + nu)."""
    cover: Array
    """Covariance of their numbers, row by row, shape (p, p)."""
    period: float
    """How long a command is held, s."""
    slip: Array | None = None
    """What places move beside the mean of two speeds, m or rad, shape (n/2, n + nu); None: 0."""
    slip_cover: Array | None = None
    """Covariance of its numbers, row by row, shape (p, p)."""

    @property
    def step(self) -> Array:
        """(A, B), shape (n, n + nu)."""
        return stepped(self.law, self.period, self.slip)

    @property
    def doubt(self) -> Array:
        """Covariance of the numbers of (A, B), between rows and numbers: (n, n+nu, n, n+nu)."""
        half, width = self.law.shape
        speeds = self.cover.reshape(half, width, half, width) * self.period**2
        result = np.zeros((2 * half, width, 2 * half, width))
        result[half:, :, half:] = speeds
        result[:half, :, half:] = 0.5 * self.period * speeds
        result[half:, :, :half] = 0.5 * self.period * speeds
        result[:half, :, :half] = 0.25 * self.period**2 * speeds
        if self.slip_cover is not None:
            result[:half, :, :half] += self.slip_cover.reshape(half, width, half, width)
        return result

    def drawn(self, count: int, rng: np.random.Generator) -> Array:
        """Return so many (A, B) drawn from it, shape (count, n, n + nu)."""
        laws = self.law + _moves(self.cover, count, rng).reshape(count, *self.law.shape)
        if self.slip is None or self.slip_cover is None:
            return np.array([stepped(law, self.period) for law in laws])
        slips = self.slip + _moves(self.slip_cover, count, rng).reshape(count, *self.law.shape)
        pairs = zip(laws, slips, strict=True)
        return np.array([stepped(law, self.period, slip) for law, slip in pairs])


def _moves(cover: Array, count: int, rng: np.random.Generator) -> Array:
    values, vectors = np.linalg.eigh(cover)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return np.asarray(rng.standard_normal((count, len(root))) @ root.T)


def read(body: Body) -> Array:
    """Return (A, B) of a body whose simulator is ours, by its steps, shape (n, n + nu)."""
    if body.sight is not None:
        back = np.linalg.pinv(body.sight)
        law, command = body.linear
        command = command if body.together is None else command @ body.together
        return np.hstack([body.sight @ law @ back, body.sight @ command])
    n, k = body.size, len(body.bounds[0])
    move = np.concatenate([np.eye(n + k), -np.eye(n + k)]) * STEP
    after = body.step(move[:, :n], move[:, n:])
    return np.asarray((after[: n + k] - after[n + k :]).T / (2.0 * STEP))


def carried(source: Body, seen_as: AffineMap, target: Body) -> Array:
    """Return what the source says of the target's accelerations, shape (n/2, n + nu).

    J v. is to be what the source would do at (S y, R a + F y); of all such accelerations the
    least is taken.
    """
    known = read(source)
    half_s, half_t = source.size // 2, target.size // 2
    law, command = known[half_s:, : source.size], known[half_s:, source.size :]
    rise = law - np.eye(source.size)[half_s:]
    state = rise @ seen_as.state_law + command @ seen_as.read_state
    rows = np.hstack([state, command @ seen_as.read_law]) / source.task.period
    back = np.linalg.pinv(seen_as.state_law[half_s:, half_t:], rcond=1e-6)
    return np.asarray(back @ rows)


def learned(seen: Transitions, before: Array | None, target: Body) -> LinearPosterior:
    """Return what is believed of a body after its transitions.

    Every row of v' - v = period law (x, u) is a regression with normal beliefs of its numbers
    about what was believed before, one width for places, one for speeds and one for commands,
    which the evidence chooses. Readings are noisy on both sides. Where the
    evidence of a row is greater without what was believed before, it is left out there.

    Source: MacKay 1992, Neural Computation 4(3), eqs. 4.2 to 4.4.

    Args:
        seen: Transitions of the target.
        before: Accelerations believed beforehand, shape (n/2, n + nu); none at all if None.
        target: Whose task tells the noise and the period.
    """
    period, noise = target.task.period, max(target.task.noise, 1e-4)
    n, k = seen.state.shape[1], seen.command.shape[1]
    half = n // 2
    mean = np.zeros((half, n + k)) if before is None else before
    unit = np.concatenate([np.ones(n), np.sqrt(np.square(seen.command).mean(axis=0)) + 1e-12])
    x = np.hstack([seen.state, seen.command]) / unit
    rise = (seen.after - seen.state)[:, half:]
    law, slip = np.zeros_like(mean), np.zeros_like(mean)
    cover = np.zeros((half, n + k, half, n + k))
    slip_cover = np.zeros_like(cover)
    mid = 0.5 * period * (seen.state + seen.after)[:, half:]
    slipped = (seen.after - seen.state)[:, :half] - mid
    for row in range(half):
        mine = np.eye(n)[half + row]
        fits = [
            _row(x, rise[:, row], period * each * unit, mine, noise)
            for each in (mean[row], np.zeros(n + k))[: 1 if before is None else 2]
        ]
        result, doubt, _ = max(fits, key=lambda fit: fit[2])
        law[row] = result / unit / period
        cover[row, :, row] = doubt / np.outer(unit, unit) / period**2
        result, doubt, _ = _row(x, slipped[:, row], np.zeros(n + k), np.eye(n)[row], noise, SMALL)
        slip[row] = result / unit
        slip_cover[row, :, row] = doubt / np.outer(unit, unit)
    size = half * (n + k)
    return LinearPosterior(
        law=law,
        cover=cover.reshape(size, size),
        period=period,
        slip=slip,
        slip_cover=slip_cover.reshape(size, size),
    )


def _row(
    x: Array, rise: Array, before: Array, mine: Array, noise: float, wide: float = 1.0
) -> tuple[Array, Array, float]:
    """Return the most probable numbers of one row, their covariance, and the log evidence."""
    n = len(mine)
    half, size = n // 2, len(before)
    left = rise - x @ before
    first = wide * np.array([4.0, 0.04, 0.09])
    width = np.repeat(first, [half, half, size - n])
    more, cover, slope = np.zeros(size), np.eye(size), before[:n] + mine
    evidence = -np.inf
    for _ in range(ROUNDS):
        variance = noise**2 * (1.0 + np.square(slope).sum())
        cover = np.linalg.inv(np.diag(1.0 / width) + x.T @ x / variance)
        more = cover @ (x.T @ left) / variance
        evidence = _evidence(x, left, width, variance)
        spread = np.square(more) + np.diag(cover)
        for group in (slice(0, half), slice(half, n), slice(n, size)):
            width[group] = np.clip(spread[group].mean(), 1e-6 * wide, 1e3)
        slope = (before + more)[:n] + mine
    return before + more, cover, evidence


def _evidence(x: Array, left: Array, width: Array, variance: float) -> float:
    """Return log p(left) of a regression whose numbers have these variances beforehand."""
    total = (x * width) @ x.T + variance * np.eye(len(x))
    log_det = float(np.linalg.slogdet(total)[1])
    return -0.5 * (float(left @ np.linalg.solve(total, left)) + log_det)


def stepped(law: Array, period: float, slip: Array | None = None) -> Array:
    """Return (A, B) of v' = v + period law (x, u), q' = q + period (v + v') / 2 + slip (x, u).

    Args:
        law: Shape (n/2, n + nu).
        period: s.
        slip: Likewise; 0 if None.
    """
    half = len(law)
    speeds = period * law
    speeds[:, half : 2 * half] += np.eye(half)
    places = 0.5 * period * speeds
    places[:, :half] += np.eye(half)
    places[:, half : 2 * half] += 0.5 * period * np.eye(half)
    return np.vstack([places if slip is None else places + slip, speeds])
