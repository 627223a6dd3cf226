"""Initial guess of a consistent map from linear models of both bodies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.maps.consistent import Guess, ScaledTransitions
from morph.alignment.maps.feature_warping import no_curves

FAINT = 1e-3
"""What of a target's variance is none: directions in which redundant numbers agree."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Beginnings:
    """The maps x = S t, u = R a that least contradict x' - x = A x + B u + c, as a Gaussian.

    With A, B and c fitted to the source's transitions, what the target's contradict is a square
    of S alone once R and an offset are put at their best. Its inverse is a covariance from which
    S is drawn: what linear models leave open, such as scales that only curvature fixes, is drawn
    widely, and what they say narrowly.
    """

    axes: Array
    """Drawn with unit variances, these make an S: shape (n m, n m)."""
    reads: Array
    """R of an S, both as one row: shape (k k_t, n m)."""
    root: Array
    """A square root of the target's covariance, shape (m, m)."""
    shape: tuple[int, int, int, int]
    """n, m, k, k_t."""
    states: Array
    """t of the target, shape (rows, m)."""

    def drawn(self, rng: np.random.Generator) -> Guess:
        """Return a map by chance."""
        n, m, k, command = self.shape
        S = (self.axes @ rng.standard_normal(n * m)).reshape(n, m)
        if rng.random() < 0.5 and n <= m:
            # Every other one sees the source's numbers as spread as they were, and unrelated.
            left, _, right = np.linalg.svd(S @ self.root, full_matrices=False)
            S = left @ right @ np.linalg.inv(self.root)
        else:
            S = S * np.sqrt(n / np.square(S @ self.root).sum())
        R = (self.reads @ S.ravel()).reshape(k, command)
        x = self.states @ S.T
        gram = x.T @ x + FAINT * len(x) * np.eye(n)
        L = np.linalg.solve(gram, x.T @ self.states).T
        return Guess(
            S=S, s=np.zeros(n), R=R, r=np.zeros(k), L=L, b=np.zeros(m),
            states=no_curves(m), commands=no_curves(command),
        )  # fmt: skip


def beginnings(x: Array, u: Array, move: Array, seen: ScaledTransitions) -> Beginnings:
    """Return what linear models of both bodies say of the map between them.

    Args:
        x: States of the source in spreads, shape (rows, n).
        u: Its commands in spreads, shape (rows, k).
        move: How far it moved from there, in spreads, shape (rows, n).
        seen: The target's transitions.
    """
    (rows, m), command, n, k = seen.before.shape, seen.command.shape[1], x.shape[1], u.shape[1]
    inputs = np.concatenate([x, u, np.ones((len(x), 1))], axis=1)
    law = np.linalg.lstsq(inputs, move, rcond=None)[0].T
    A, B = law[:, :n], law[:, n : n + k]
    weight = 1.0 / np.maximum(move.std(axis=0), 1e-6)
    change = seen.after - seen.before
    one = np.eye(n)
    # Row i of what is contradicted: S_i (t' - t) - sum_j A_ij S_j t - B_i R a - offset_i.
    by_S = np.einsum("ij,Nm->Nijm", one, change) - np.einsum("ij,Nm->Nijm", A, seen.before)
    by_R = -np.einsum("ik,Nc->Nikc", B, seen.command).reshape(rows, n, -1)
    rest = np.concatenate([by_R, np.broadcast_to(one, (rows, n, n))], axis=2)
    D = (by_S.reshape(rows, n, -1) * weight[:, None]).reshape(rows * n, -1)
    E = (rest * weight[:, None]).reshape(rows * n, -1)
    inner = E.T @ E + 1e-6 * rows * np.eye(E.shape[1])
    best = np.linalg.solve(inner, E.T @ D)
    spread = np.cov(seen.before.T).reshape(m, m) + FAINT * np.eye(m)
    root = np.asarray(np.linalg.cholesky(spread), dtype=float)
    # Of maps equally spread over the target's states, those that contradict less.
    even = np.linalg.inv(np.kron(one, root))
    value, vector = np.linalg.eigh(even @ (D.T @ D - D.T @ E @ best) @ even.T / rows)
    value = np.maximum(value, 0.0)
    axes = even.T @ (vector / np.sqrt(value + 0.3 * value[0] + 1e-9))
    return Beginnings(
        axes=axes,
        reads=-best[: k * command],
        root=root,
        shape=(n, m, k, command),
        states=seen.before,
    )
