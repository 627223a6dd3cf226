"""A few postures that stand for all: a squared exponential as a product of short features."""

from __future__ import annotations

from dataclasses import dataclass

import torch

TOLERANCE = 1e-4
"""Share of a function's variance that the features may leave out."""

MOST = 200
"""Most landmarks."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Landmarks:
    """Features f with f(x) . f(x') = exp(-|x - x'|^2 / 2), nearly, wherever landmarks are near.

    With k the kernel and Z the landmarks, f(x) = inv(L) k(Z, x) and L L' = k(Z, Z).

    Source: Williams and Seeger 2001, Using the Nystroem Method to Speed Up Kernel Machines.
    """

    points: torch.Tensor
    """The landmarks in units of the kernel's lengths, shape (m, numbers)."""
    whiten: torch.Tensor
    """inv(L)', by which a row of k(x, Z) becomes a row of features, shape (m, m)."""

    def features(self, points: torch.Tensor) -> torch.Tensor:
        """Return the features of points, shape (..., m)."""
        return exponential(points, self.points) @ self.whiten


def landmarks(candidates: torch.Tensor) -> Landmarks:
    """Return landmarks chosen among candidates, each where the others say least.

    Source: Harbrecht, Peters and Schneider 2012, Applied Numerical Mathematics 62 (the pivoted
    Cholesky factorisation).

    Args:
        candidates: Points over all that will be asked about, shape (n, numbers).
    """
    unsaid = torch.ones(len(candidates), dtype=torch.float64)
    columns: list[torch.Tensor] = []
    chosen: list[int] = []
    while len(chosen) < min(MOST, len(candidates)) and float(unsaid.max()) > TOLERANCE:
        pivot = int(unsaid.argmax())
        column = exponential(candidates, candidates[pivot : pivot + 1])[:, 0]
        for before in columns:
            column = column - before * before[pivot]
        column = column / unsaid[pivot].sqrt()
        columns.append(column)
        chosen.append(pivot)
        unsaid = (unsaid - column**2).clamp(min=0.0)
    lower = torch.stack(columns, dim=-1)[chosen].tril()
    one = torch.eye(len(chosen), dtype=torch.float64)
    whiten = torch.linalg.solve_triangular(lower, one, upper=False).T
    return Landmarks(points=candidates[chosen].contiguous(), whiten=whiten.contiguous())


def exponential(these: torch.Tensor, those: torch.Tensor) -> torch.Tensor:
    """Return exp(-|x - y|^2 / 2) of all pairs, shape (..., m) of x (..., k) and y (m, k)."""
    squares = 0.5 * (these**2).sum(-1, keepdim=True) + 0.5 * (those**2).sum(-1)
    return torch.exp((these @ those.T - squares).clamp(max=0.0))
