"""The linear regulator: the feedback that holds a body where it can rest, at the least cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

from morph.arrays import Array
from morph.errors import SearchError

KEPT = 0.999
"""What a period's cost counts against the period before it.

With a discount just below 1 a mode that no command moves and that does not grow, such as the
drift of a board that nothing drives, has a finite cost and is left alone.
"""

GROWS = 1.0 + 1e-4
"""Size of an eigenvalue from which a mode counts as growing."""

UNMOVED = 1e-7
"""Size, against that of A, below which the commands do not move a mode."""

EFFORTS = tuple(10.0**power for power in np.arange(-4.0, 2.25, 0.25))
"""What effort may cost, from which the noise chooses."""


@dataclass(frozen=True, kw_only=True)
class Regulator:
    """Feedback u = u0 + gain (x - x0) about a state of rest."""

    gain: Array
    """Shape (m, n)."""
    worth: Array
    """The cost-to-go is 1/2 dx' worth dx, shape (n, n)."""
    effort: float
    """The cost of effort with which it was made."""
    noisy: float
    """The cost of a period at which it rests under the noise that it was made for."""


def lqr(A: Array, B: Array, Q: Array, R: Array, *, where: str, kept: float = KEPT) -> Regulator:
    """Return the regulator that makes sum kept^t 1/2 (x' Q x + u' R u) least.

    K = -inv(R + B' P B) B' P A with P of the discrete Riccati equation, A and B scaled by
    sqrt(kept).

    Source: Anderson and Moore 1990, Optimal Control: Linear Quadratic Methods, chapter 2;
    discounting, section 3.5.

    Args:
        A: Shape (n, n), of x' = A x + B u.
        B: Shape (n, m).
        Q: Shape (n, n), positive semidefinite.
        R: Shape (m, m), positive definite.
        where: What an error names as its place.
        kept: The discount, above 0 and at most 1.

    Raises:
        SearchError: A mode grows that no command moves, or the equation has no solution.
    """
    modes = lost_modes(A, B)
    if modes:
        largest, mode = modes[0]
        raise SearchError(
            f"a motion grows {abs(largest):.3g}-fold each period and no command moves it; "
            f"it is mostly in number {int(np.argmax(np.abs(mode)))} of the state",
            where=where,
            fix="give an actuator that moves this joint, or another state to hold",
        )
    scale = np.sqrt(kept)
    try:
        P = solve_discrete_are(scale * A, scale * B, Q, R)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise SearchError(
            f"the Riccati equation has no solution: {error}",
            where=where,
            fix="let the cost see every joint, and give effort a cost above 0",
        ) from error
    P = 0.5 * (P + P.T)
    K = -np.linalg.solve(R + kept * B.T @ P @ B, kept * B.T @ P @ A)
    return Regulator(gain=K, worth=P, effort=float("nan"), noisy=float("nan"))


def lost_modes(A: Array, B: Array) -> list[tuple[complex, Any]]:
    """Return growing eigenvalues that no command moves, the largest first, with their modes.

    Source: Hautus 1969: z is stabilisable if [z I - A, B] has full rank.
    """
    results = []
    values, vectors = np.linalg.eig(A.T)
    size = float(np.abs(A).max(initial=1.0))
    reach = float(np.abs(B).max(initial=0.0))
    for value, left in zip(values, vectors.T, strict=True):
        moved = np.abs(left @ B).max(initial=0.0)
        if abs(value) > GROWS and moved <= UNMOVED * size * max(reach, UNMOVED):
            results.append((complex(value), left))
    return sorted(results, key=lambda each: -abs(each[0]))


def noise_aware(
    A: Array,
    B: Array,
    Q: Array,
    R: Array,
    noise: Array,
    *,
    where: str,
    bounds: Array,
) -> Regulator:
    """Return the regulator that rests at the least cost though every observation is noisy.

    The feedback sees x + w and so shakes what it holds: with w of covariance W the state has the
    covariance S = (A + B K) S (A + B K)' + B K W K' B', and a period costs 1/2 trace(Q S). What
    effort costs is a knob: dear effort makes gains small and the body sway, cheap effort makes
    gains large and the noise loud. One that shakes commands beyond a third of their bounds is
    not taken if another does not.

    Args:
        A: Shape (n, n).
        B: Shape (n, m).
        Q: What a state costs, shape (n, n).
        R: What a command costs at effort 1, shape (m, m).
        noise: Standard deviation of each number of the observed state, shape (n,).
        where: What an error names as its place.
        bounds: How far each command may go, shape (m,).
    """
    best: Regulator | None = None
    W = np.diag(noise**2)
    least = np.inf
    for effort in EFFORTS:
        try:
            result = lqr(A, B, Q, effort * R, where=where)
        except SearchError:
            if lost_modes(A, B):
                raise
            continue
        K = result.gain
        closed = np.sqrt(KEPT) * (A + B @ K)
        if np.abs(np.linalg.eigvals(closed)).max() >= 1.0:
            continue
        S = solve_discrete_lyapunov(closed, B @ K @ W @ K.T @ B.T)
        noisy = 0.5 * float(np.trace(Q @ S))
        shaken = np.sqrt(np.maximum(np.diag(K @ (S + W) @ K.T), 0.0))
        score = noisy * (1.0 + 100.0 * max(float((shaken / bounds).max()) - 1.0 / 3.0, 0.0))
        if score < least:
            best, least = (
                Regulator(gain=K, worth=result.worth, effort=effort, noisy=noisy),
                score,
            )
    if best is None:
        raise SearchError(
            "no regulator holds this state",
            where=where,
            fix="give another state to hold, or actuators for more of its joints",
        )
    return best
