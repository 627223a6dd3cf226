"""What few noisy transitions tell about a body near rest: linear models and how likely each is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import SamplesError, SettingError
from morph.alignment.samples import Transitions

STEADY = (0.0, 0.5, 2.0)
"""What a step adds of its own, in standard deviations of a reading; the evidence chooses."""

BENDS = (0.03, 0.0, 0.003, 0.3)
"""What a step adds by each square of how far from rest it begins: no law is straight far away."""

WIDTHS = (1.0, 0.3, 3.0, 10.0)
"""Standard deviations of a law's weights, in spreads of what follows by spreads of what it is
of; the evidence chooses."""

STIFF, DAMPED, STRONG = 40.0, 1.0, 40.0
"""Accelerations, rad/s2 or m/s2, by a unit of place, of speed, and of a whole command."""

PASSES = 12
"""Most steps of Gauss and Newton."""

FEWEST = 8
"""Fewest transitions that say anything."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Belief:
    """x' = F (x; u) + w, with F = base + lift Theta and Theta normally distributed."""

    base: Array
    """What is known of F beforehand, shape (n, n + k)."""
    lift: Array
    """Which numbers of the state the unknown rows act on, shape (n, rows)."""
    mean: Array
    """Theta, shape (rows, n + k)."""
    root: Array
    """L with L L' the covariance of Theta row after row, shape (p, p)."""
    noise: Array
    """Standard deviation of a reading, shape (n,)."""
    steady: float
    """What a step adds of its own, in standard deviations of a reading."""
    bend: float
    """What it adds by the square of how far from rest it begins."""
    evidence: float
    """Log of how probable the readings are, up to a constant of the body."""
    misfit: float
    """Mean square of a prediction's error over its variance: 1 where the model is right."""

    @property
    def law(self) -> Array:
        """The mean of F, shape (n, n + k)."""
        return np.asarray(self.base + self.lift @ self.mean)

    def drawn(self, count: int, rng: np.random.Generator) -> Array:
        """Return so many F drawn from the belief, shape (count, n, n + k)."""
        chance = rng.standard_normal((count, len(self.root))) @ self.root.T
        return np.asarray(
            self.base + self.lift @ (self.mean + chance.reshape(-1, *self.mean.shape))
        )


def mechanical(positions: int, half: Array, period: float) -> tuple[Array, Array, Array]:
    """Return base, lift and widths of x = (q, v): v' = v + a, q' = q + period (v + v') / 2.

    Accelerations alone are unknown; within a period they are taken for constant. Beforehand they
    are thought to be of the order of `STIFF` a unit of place, `DAMPED` a unit of speed, and
    `STRONG` under a whole command.

    Args:
        positions: How many numbers q has.
        half: A whole command, shape (k,).
        period: How long each is held, s.
    """
    one, none = np.eye(positions), np.zeros((positions, len(half)))
    base = np.block([[one, period * one, none], [0.0 * one, one, none]])
    row = np.concatenate([np.full(positions, STIFF), np.full(positions, DAMPED), STRONG / half])
    return base, np.concatenate([0.5 * period * one, one]), np.tile(period * row, (positions, 1))


def believed(
    seen: Transitions,
    *,
    noise: Array,
    base: Array | None = None,
    lift: Array | None = None,
    wide: Array | None = None,
) -> Belief:
    """Return what transitions tell about x' = F (x; u), every reading having its noise.

    A transition that begins where the one before ended shares its reading; a Kalman filter goes
    along such runs, and the weights are those that make its predictions most probable (Gauss and
    Newton), with their curvature for covariance (Laplace). Least squares alone would take the
    noise of readings for damping: its weights shrink where a state hardly moves.

    Source: Ljung 1999, System Identification, chapters 7.4 and 10.2 (prediction errors and their
    gradient); MacKay 1992, Neural Computation 4(3) (the evidence chooses how wide a prior is).

    Args:
        seen: What the body did.
        noise: Standard deviation of every number of a reading, shape (n,), above 0.
        base: What is known of F beforehand, shape (n, n + k); that nothing moves, if None.
        lift: Where what is unknown acts, shape (n, rows); everywhere, if None.
        wide: Standard deviations of Theta beforehand, to a factor that the evidence chooses,
            shape (rows, n + k); in spreads of the data, if None.

    Raises:
        SamplesError: There are too few transitions, or no command moves anything.
        SettingError: A noise is not above 0.
    """
    (m, n), k = seen.state.shape, seen.command.shape[1]
    if m < FEWEST:
        raise SamplesError(
            f"{m} transitions say nothing of {n} states and {k} commands",
            where="a belief about a body",
            fix=f"give {FEWEST} or more",
        )
    if noise.shape != (n,) or not (noise > 0.0).all():
        raise SettingError(
            f"the noise is {noise}",
            where="a belief about a body",
            fix=f"give {n} standard deviations above 0",
        )
    if not (seen.command.std(axis=0) > 1e-9).all():
        raise SamplesError(
            f"command {int(np.argmin(seen.command.std(axis=0)))} never changed",
            where="a belief about a body",
            fix="move every command at random about rest",
        )
    known = np.concatenate([np.eye(n), np.zeros((n, k))], axis=1) if base is None else base
    acts = np.eye(n) if lift is None else lift
    runs = _runs(seen)
    prior = _spread(seen, known, acts) if wide is None else wide
    fit = (runs, noise, known, acts, prior)
    best = _fitted(*fit, (STEADY[0], BENDS[0], WIDTHS[0]), None)
    chosen = [STEADY[0], BENDS[0], WIDTHS[0]]
    for at, grid in ((2, WIDTHS), (1, BENDS), (0, STEADY), (2, WIDTHS), (1, BENDS)):
        for value in grid:
            trial = [*chosen[:at], value, *chosen[at + 1 :]]
            if trial == chosen:
                continue
            each = _fitted(*fit, (trial[0], trial[1], trial[2]), best)
            if each.evidence > best.evidence:
                best, chosen = each, trial
    return best


def _runs(seen: Transitions) -> list[tuple[Array, Array]]:
    """Return readings (T + 1, n) and commands (T, k) of every run that hangs together."""
    follows = (seen.state[1:] == seen.after[:-1]).all(axis=1)
    cuts = np.flatnonzero(~follows) + 1
    runs = []
    for rows in np.split(np.arange(len(seen.state)), cuts):
        reading = np.concatenate([seen.state[rows[:1]], seen.after[rows]])
        runs.append((reading, seen.command[rows]))
    return runs


def _spread(seen: Transitions, base: Array, lift: Array) -> Array:
    """Return widths of Theta in spreads of what follows by spreads of what it is of."""
    z = np.concatenate([seen.state, seen.command], axis=1)
    left = (seen.after - z @ base.T) @ np.linalg.pinv(lift).T
    wide = np.sqrt(np.square(left).mean(axis=0))[:, None] / np.sqrt(np.square(z).mean(axis=0))
    return np.asarray(np.maximum(wide, 1e-9))


def _fitted(
    runs: list[tuple[Array, Array]],
    noise: Array,
    base: Array,
    lift: Array,
    wide: Array,
    setting: tuple[float, float, float],
    begin: Belief | None,
) -> Belief:
    """Return the belief under a setting: what steps add, how straight laws are, how wide."""
    steady, bend, width = setting
    precise = 1.0 / np.square(width * wide).ravel()
    shape = wide.shape
    theta = np.zeros(precise.shape) if begin is None else begin.mean.ravel()
    best = _filtered(theta.reshape(shape), runs, noise, base, lift, steady, bend)
    score = best[0] - 0.5 * float(precise @ theta**2)
    shrink = 1.0
    for _ in range(PASSES):
        _, slope, curve, _ = best
        step = np.linalg.solve(curve + np.diag(precise), slope - precise * theta)
        tried = theta + shrink * step
        new = _filtered(tried.reshape(shape), runs, noise, base, lift, steady, bend)
        gained = new[0] - 0.5 * float(precise @ tried**2) - score
        if not gained > 0.0:
            shrink *= 0.3
            if shrink < 0.01:
                break
            continue
        theta, best, score, shrink = tried, new, score + gained, min(1.0, 2.0 * shrink)
        if gained < 0.01:
            break
    low = np.linalg.cholesky(best[2] + np.diag(precise))
    evidence = score + 0.5 * float(np.log(precise).sum()) - float(np.log(np.diag(low)).sum())
    root = np.linalg.solve(low, np.eye(len(low))).T
    return Belief(
        base=base, lift=lift, mean=theta.reshape(shape), root=root, noise=noise,
        steady=steady, bend=bend, evidence=evidence, misfit=best[3],
    )  # fmt: skip


def _filtered(
    theta: Array,
    runs: list[tuple[Array, Array]],
    noise: Array,
    base: Array,
    lift: Array,
    steady: float,
    bend: float,
) -> tuple[float, Array, Array, float]:
    """Return the log likelihood, its slope and curvature in theta, and the misfit.

    The gains of the filter are taken for constant while the slope is taken.
    """
    law = base + lift @ theta
    n, p = len(base), theta.size
    A, R = law[:, :n], np.diag(noise**2)
    # What a step adds of its own comes in where the unknown acts: accelerations that no law has.
    pushed = lift @ lift.T
    pushed = pushed / pushed.max()
    level = steady * float(np.mean(noise))
    total, slope, curve, square, count = 0.0, np.zeros(p), np.zeros((p, p)), 0.0, 0
    with np.errstate(over="ignore", invalid="ignore"):
        for reading, command in runs:
            x, V, J = reading[0], R, np.zeros((n, p))
            for u, y in zip(command, reading[1:], strict=True):
                z = np.concatenate([x, u])
                J = A @ J + (lift[:, :, None] * z).reshape(n, p)
                own = level + bend * min(float(x @ x), 1e3)
                x, V = law @ z, A @ V @ A.T + own**2 * pushed
                S = V + R
                inverse = np.linalg.inv(S)
                e = y - x
                weighted = inverse @ e
                total -= 0.5 * (float(e @ weighted) + float(np.linalg.slogdet(S)[1]))
                square, count = square + float(e @ weighted), count + n
                slope += J.T @ weighted
                curve += J.T @ inverse @ J
                gain = V @ inverse
                x, J, V = x + gain @ e, J - gain @ J, V - gain @ V
    if not np.isfinite(total):
        return -np.inf, slope, curve, np.inf
    return total, slope, curve, square / count
