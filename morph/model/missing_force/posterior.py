"""What runs say of a body's figures and of a force on it, once the states are taken out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cho_solve_banded, cholesky_banded

from morph.arrays import Array
from morph.model.missing_force.periods import Slopes

FLOOR = 0.02
"""Least unexplained jump of a state in a period, in standard deviations of its noise."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Reduced:
    """Minus twice the log likelihood of a run: h' D h - 2 b' h + c, with h = (p, f_1 .. f_T).

    The states were taken out: of every h the likeliest are taken, and how wide they are counts.
    """

    information: Array
    """D, shape (size + periods * joints,) twice."""
    vector: Array
    """b."""
    constant: float
    """c."""
    size: int
    """How many numbers p has."""
    factor: Array
    """Banded Cholesky factor of the states' precision."""
    across: Array
    """The precision between states and h, shape (states, len(h))."""
    pull: Array
    """The gradient in the states where the slopes were taken, shape (states,)."""
    about: Array
    """h where the slopes were taken."""

    def states(self, h: Array) -> Array:
        """Return how far the likeliest states are from where the slopes were taken; (T + 1, n)."""
        right = self.pull + self.across @ (h - self.about)
        return np.asarray(-cho_solve_banded((self.factor, True), right))

    def through(self, features: Array) -> tuple[Array, Array]:
        """Return D and b of (p, weights), for mean features (periods, joints, count)."""
        periods, joints, count = features.shape
        map_ = np.zeros((len(self.vector), self.size + joints * count))
        map_[: self.size, : self.size] = np.eye(self.size)
        inner = map_[self.size :, self.size :].reshape(periods, joints, joints, count)
        for joint in range(joints):
            inner[:, joint, joint] = features[:, joint]
        return map_.T @ self.information @ map_, map_.T @ self.vector


def jump_variance(jump: Array, noise: Array, period: float) -> Array:
    """Return the variance of what no force explains in a period, shape (n,).

    White forces through a period h that change a velocity by the standard deviation r leave the
    place r h / sqrt(3) off; a little is added, as without it states would be tied too stiffly.

    Args:
        jump: r of each velocity, shape (joints,).
        noise: Standard deviation of each state's noise, shape (n,).
        period: h, s.
    """
    place = jump * period / np.sqrt(3.0)
    return np.asarray(np.concatenate([place, jump]) ** 2 + (FLOOR * noise) ** 2)


def reduced(slopes: Slopes, seen: Array, noise: Array, jump: Array) -> Reduced:
    """Return what a run says of (p, f), the states taken out.

    With y = x + noise and x_{t+1} = F(x_t, u_t; p, f_t) + jump, linearised about what is believed,
    the states' normal equations are banded. An observation's noise enters two transitions, and
    what it does to both is counted as what it is: one noise.

    Source: Bell 1994, SIAM Journal on Optimization 4(3), for the smoother as a Gauss-Newton step;
    Rasmussen and Williams 2006, eq. 2.41, for the algebra of what is taken out.

    Args:
        slopes: The run, linearised.
        seen: y, shape (periods + 1, n).
        noise: Its standard deviations, shape (n,).
        jump: Variances of the jumps, shape (n,).
    """
    A, count = slopes.of_state, len(slopes.missed)
    n, joints, size = A.shape[1], slopes.of_force.shape[2], slopes.of_point.shape[2]
    Q = 1.0 / jump
    R = 1.0 / noise**2
    off = seen - slopes.state
    blocks = np.zeros((count + 1, n, n))
    blocks += np.diag(R)
    blocks[1:] += np.diag(Q)
    blocks[:-1] += np.swapaxes(A, 1, 2) @ (Q[:, None] * A)
    pull = -off * R
    pull[1:] += Q * slopes.missed
    pull[:-1] -= np.einsum("tij,ti->tj", A, Q * slopes.missed)
    # P_t: how period t answers to p and to its own force.
    P = np.zeros((count, n, size + count * joints))
    P[:, :, :size] = slopes.of_point
    for at in range(count):
        P[at, :, size + at * joints : size + (at + 1) * joints] = slopes.of_force[at]
    QP = Q[:, None] * P
    across = np.zeros((count + 1, n, P.shape[2]))
    across[1:] -= QP
    across[:-1] += np.swapaxes(A, 1, 2) @ QP
    whole = P.reshape(-1, P.shape[2])
    inner = whole.T @ QP.reshape(whole.shape)
    gradient = -whole.T @ (Q * slopes.missed).ravel()
    factor = cholesky_banded(_banded(blocks, -Q[:, None] * A), lower=True)
    across, pull = across.reshape(-1, P.shape[2]), pull.ravel()
    known = cho_solve_banded((factor, True), np.column_stack([across, pull]))
    D = inner - across.T @ known[:, :-1]
    b = across.T @ known[:, -1] - gradient
    about = np.concatenate([slopes.point, slopes.force.ravel()])
    c = float((off**2 * R).sum() + (slopes.missed**2 * Q).sum() - pull @ known[:, -1])
    c += 2.0 * float(np.log(factor[0]).sum())
    c += (count + 1) * float(np.log(noise**2).sum()) + count * float(np.log(jump).sum())
    moved = D @ about
    return Reduced(
        information=D,
        vector=b + moved,
        constant=c + float(2.0 * b @ about + about @ moved),
        size=size,
        factor=factor,
        across=across,
        pull=pull,
        about=about,
    )


def _banded(blocks: Array, below: Array) -> Array:
    """Return a symmetric block tridiagonal matrix in LAPACK's lower banded form."""
    count, n, _ = blocks.shape
    band = np.zeros((2 * n, count * n))
    for row in range(n):
        for column in range(n):
            if row >= column:
                band[row - column, column::n] = blocks[:, row, column]
            band[n + row - column, column : (count - 1) * n : n] = below[:, row, column]
    return band


@dataclass(frozen=True, kw_only=True, eq=False)
class Posterior:
    """A normal distribution of a body's figures and of the weights of the force on it."""

    mean: Array
    """Shape (size + weights,)."""
    factor: Array
    """Lower Cholesky factor of its precision."""
    log_evidence: float
    """log p(runs), but for its constant: that of Laplace's approximation."""

    def drawn(self, count: int, rng: np.random.Generator, scale: float = 1.0) -> Array:
        """Return draws, shape (count, size + weights).

        Args:
            count: How many.
            rng: Chance.
            scale: What the standard deviations are multiplied by.
        """
        # inv(L') z has the covariance inv(L L').
        chance = rng.normal(size=(len(self.mean), count))
        return self.mean + scale * np.linalg.solve(self.factor.T, chance).T


def posterior(
    parts: Sequence[tuple[Array, Array]], constant: float, start: Array, variance: Array
) -> Posterior:
    """Return what runs say together with a prior.

    Args:
        parts: D and b of each run, in (p, weights).
        constant: The sum of the runs' c.
        start: Prior means, shape (size + weights,).
        variance: Prior variances, likewise.
    """
    trust = 1.0 / variance
    precision = np.sum([D for D, _ in parts], axis=0) + np.diag(trust)
    right = np.sum([b for _, b in parts], axis=0) + trust * start
    L, _ = cho_factor(precision, lower=True)
    mean = cho_solve((L, True), right)
    twice = constant + float(start @ (trust * start)) - float(right @ mean)
    twice += 2.0 * float(np.log(np.diag(L)).sum()) + float(np.log(variance).sum())
    return Posterior(mean=mean, factor=np.tril(L), log_evidence=-0.5 * twice)
