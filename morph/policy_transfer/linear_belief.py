"""What is believed of how a body moves about its rest, x' = A x + B u, from what it did."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.errors import MorphError, SearchError, TransferError
from morph.search.regulator.lqr import noise_aware

UNKNOWN = (1.0, 5.0, 25.0, 125.0)
"""Spreads, per s, of what is not known at all, from which the evidence chooses."""

RIDGES = (1e-8, 1e-6, 1e-4, 1e-2, 1.0)
"""What weights of a regression cost, from which transitions left out choose."""

LONGEST = 15
"""Transitions after which a run is taken to begin anew."""

STEPS = 10
"""Most steps towards the most probable."""

Model = Callable[[Array], tuple[Array, Array]]
"""From p numbers to W = [A B], shape (n, n + nu), and the derivative of W.ravel(), (d, p)."""

Readings = list[tuple[Array, Array]]
"""Runs: what was read, shape (m + 1, n), and what was commanded between, shape (m, nu)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearBelief:
    """A normal distribution of numbers that make W.

    Readings y_t = x_t + noise of a run, x_t+1 = W (x_t, u_t) from any x_0, update it to the most
    probable numbers and, about those, to what a second derivative tells (Laplace). So noise of
    the readings does not bias it, as it would a regression from reading to reading.

    Source: Bishop 2006, Pattern Recognition and Machine Learning, section 4.4; Ljung 1999, System
    Identification, section 3.2, for models that are judged by whole runs.
    """

    model: Model
    """How the numbers make W."""
    mean: Array
    """The most probable numbers, shape (p,)."""
    covariance: Array
    """Of the numbers, shape (p, p)."""
    evidence: float = 0.0
    """log p(readings) before they were known, less a constant, of the last ones seen."""

    def __post_init__(self) -> None:
        """Check the shapes."""
        size = len(self.mean)
        if self.covariance.shape != (size, size):
            raise TransferError(
                f"its covariance has the shape {self.covariance.shape}, and it has {size} numbers",
                where="a belief of a linear body",
                fix="give one row and one column for each number",
            )

    @property
    def linear(self) -> Array:
        """The most probable [A B], shape (n, n + nu)."""
        return self.model(self.mean)[0]

    def changed(self, spread: Array) -> LinearBelief:
        """Return what is believed after a change by chance, of such standard deviations (p,)."""
        after = self.covariance + np.diag(np.square(spread))
        return LinearBelief(model=self.model, mean=self.mean, covariance=after)

    def seen(self, transitions: Transitions, *, noise: float) -> LinearBelief:
        """Return what is believed after transitions whose readings had such a noise."""
        parts = readings(transitions)
        precision = np.linalg.inv(self.covariance)

        def told(point: Array) -> _Told:
            off = point - self.mean
            result = _told(*self.model(point), parts, noise)
            return _Told(
                cost=result.cost + 0.5 * float(off @ precision @ off),
                curve=result.curve + precision,
                pull=result.pull - precision @ off,
            )

        point, best, trust = self.mean, told(self.mean), 1.0
        for _ in range(STEPS):
            further = point + trust * np.linalg.solve(best.curve, best.pull)
            try:
                tried = told(further)
            except MorphError:
                # There is no such body: as little likely as can be.
                tried = replace(best, cost=np.inf)
            gained = best.cost - tried.cost
            if not gained > 0.0:
                trust *= 0.3
                continue
            point, best, trust = further, tried, min(1.0, 2.0 * trust)
            if gained < 1e-3:
                break
        covariance = np.linalg.inv(best.curve)
        volume = np.linalg.slogdet(best.curve)[1] - np.linalg.slogdet(precision)[1]
        return LinearBelief(
            model=self.model,
            mean=point,
            covariance=0.5 * (covariance + covariance.T),
            evidence=-best.cost - 0.5 * float(volume),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Told:
    """How well numbers explain readings, and which way better ones lie."""

    cost: float
    """-log of a probability, less a constant."""
    curve: Array
    """Its second derivative, shape (p, p), positive definite."""
    pull: Array
    """Less its first derivative, shape (p,)."""


def _told(W: Array, slope: Array, parts: Readings, noise: float) -> _Told:
    """Return how well W explains runs, each from the beginning that suits it best."""
    n = len(W)
    A = W[:, :n]
    cost = 0.0
    curve, pull = np.zeros((slope.shape[1],) * 2), np.zeros(slope.shape[1])
    shaped = slope.reshape(*W.shape, -1)
    with np.errstate(over="ignore", invalid="ignore"):
        for seen, command in parts:
            x, by, begun = seen[0], np.zeros((n, slope.shape[1])), np.eye(n)
            off, slopes, starts = [seen[0] - x], [by], [begun]
            for u, y in zip(command, seen[1:], strict=True):
                known = np.concatenate([x, u])
                by = A @ by + np.einsum("ijp,j->ip", shaped, known)
                begun, x = A @ begun, W @ known
                off.append(y - x)
                slopes.append(by)
                starts.append(begun)
            free = np.concatenate(starts)
            left, turned = np.concatenate(off) / noise, np.concatenate(slopes) / noise
            if not (np.isfinite(left).all() and np.isfinite(turned).all()):
                return _Told(cost=np.inf, curve=curve, pull=pull)
            free, _ = np.linalg.qr(free)
            # What another beginning explains says nothing of W.
            left, turned = left - free @ (free.T @ left), turned - free @ (free.T @ turned)
            cost += 0.5 * float(left @ left)
            curve += turned.T @ turned
            pull += turned.T @ left
    return _Told(cost=cost, curve=curve, pull=pull)


def readings(transitions: Transitions) -> Readings:
    """Return transitions as runs: those that go on from where the one before ended."""
    goes_on = (transitions.state[1:] == transitions.after[:-1]).all(axis=1)
    parts: Readings = []
    begun, many = 0, len(transitions.state)
    for at in range(1, many + 1):
        if at < many and goes_on[at - 1] and at - begun < LONGEST:
            continue
        seen = np.concatenate([transitions.state[begun:at], transitions.after[at - 1 : at]])
        parts.append((seen, transitions.command[begun:at]))
        begun = at
    return parts


def regulator(W: Array, outcome: Array, bounds: tuple[Array, Array], *, noise: float) -> Array:
    """Return the regulator of W = [A B], u = gain x, shape (nu, n); zeros if nothing holds it.

    Args:
        W: Shape (n, n + nu).
        outcome: z = C x is what is to be small, shape (numbers, n).
        bounds: Least and greatest commands about rest, shape (nu,) both.
        noise: Of every observation.
    """
    n = len(W)
    A, B = W[:, :n], W[:, n:]
    half = np.minimum(np.minimum(-bounds[0], bounds[1]), 2.0 * np.pi)
    # A trace of cost on every number lets the equation see what the task does not look at.
    Q = outcome.T @ outcome + 1e-6 * np.eye(n)
    R = np.diag(half**-2.0)
    try:
        return noise_aware(A, B, Q, R, np.full(n, noise), where="a belief", bounds=half).gain
    except SearchError:
        return np.zeros((B.shape[1], n))


def anew(transitions: Transitions, period: float, *, noise: float) -> Array:
    """Return [A B] that transitions alone tell; how little was known before, evidence chooses.

    Known beforehand is only that a place changes by its rate times the time.
    """
    size, commands = transitions.state.shape[1], transitions.command.shape[1]
    half = size // 2
    begun = np.concatenate([np.eye(size), np.zeros((size, commands))], axis=1)
    begun[:half, half:size] += period * np.eye(half)
    each = np.eye(begun.size)

    def model(point: Array) -> tuple[Array, Array]:
        return point.reshape(begun.shape), each

    results = []
    for spread in UNKNOWN:
        free = np.full_like(begun, period * spread)
        free[:half] *= period
        known = LinearBelief(
            model=model, mean=begun.ravel(), covariance=np.diag(np.square(free.ravel()))
        )
        results.append(known.seen(transitions, noise=noise))
    return max(results, key=lambda one: one.evidence).linear


def regressed(transitions: Transitions) -> Array:
    """Return [A B] by least squares from reading to reading; transitions left out choose a ridge.

    Source: Golub, Heath and Wahba 1979, Technometrics 21(2), for the choice.
    """
    known = np.concatenate([transitions.state, transitions.command], axis=1)
    u, s, v = np.linalg.svd(known, full_matrices=False)
    best, least = np.zeros((known.shape[1], transitions.after.shape[1])), np.inf
    for ridge in RIDGES:
        share = s**2 / (s**2 + ridge * len(known))
        fitted = u @ (share[:, None] * (u.T @ transitions.after))
        left = np.maximum(1.0 - (u**2 @ share), 1e-6)
        error = float(np.mean(((transitions.after - fitted) / left[:, None]) ** 2))
        if error < least:
            weight = share / np.where(s > 0.0, s, np.inf)
            best, least = v.T @ (weight[:, None] * (u.T @ transitions.after)), error
    return best.T
