"""Gram matrices of columns whitened by a Kalman filter, and the likelihood of readings."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.inference.filter import Disturbance, FilterRun, Tangent

CHUNK = 2**22
"""Whitened numbers held at once: 32 MiB of doubles."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Whitened:
    """Inner products of columns, whitened by a filter's innovations, over all readings."""

    gram: Array
    """The Gram matrix D' S^-1 D of columns D, S the covariance of readings, shape (columns,
    columns)."""
    logarithm: float
    """Log determinant of S."""
    readings: int
    """How many readings there are."""

    def log_likelihood(self, column: int = 0) -> float:
        """Return the log likelihood of the readings that one column holds, normalised."""
        square = float(self.gram[column, column])
        return -0.5 * (square + self.logarithm + self.readings * math.log(2.0 * math.pi))


def whitened(
    tangent: Tangent, disturbance: Disturbance, readings: Array, accelerations: Array | None = None
) -> Whitened:
    """Return the Gram matrix of columns in the metric of the readings, by one Kalman filter.

    A column changes readings directly, and through accelerations that move the state. With S the
    covariance of all readings under the disturbance and D their changes, the matrix is D' S^-1 D.

    Source: Simon 2006, Optimal State Estimation, sections 6.1 and 10.2.

    Args:
        tangent: The linearised robot.
        disturbance: What else moves it, and the noise.
        readings: Direct change of each reading, shape (samples, channels, columns).
        accelerations: Acceleration by each column, per s2, shape (samples, dofs, columns); by
            default none.

    Raises:
        KernelError: There is no C compiler, or it fails.
    """
    (whole,) = whitened_blocks(tangent, disturbance, readings, accelerations, blocks=1)
    return whole


def whitened_blocks(
    tangent: Tangent,
    disturbance: Disturbance,
    readings: Array,
    accelerations: Array | None = None,
    *,
    blocks: int,
) -> list[Whitened]:
    """Return the Gram matrices of stretches of equal length, each given all readings before it.

    Their sum is that of the run. See `whitened`, also for what is raised.

    Args:
        tangent: The linearised robot.
        disturbance: What else moves it, and the noise.
        readings: Direct change of each reading, shape (samples, channels, columns).
        accelerations: Acceleration by each column, per s2, shape (samples, dofs, columns).
        blocks: How many stretches there are.
    """
    samples, columns = len(tangent.jacobian), readings.shape[2]
    run, result = FilterRun(tangent, disturbance, columns), []
    for block in range(blocks):
        gram, logarithm = np.zeros((columns, columns)), 0.0
        first, last = block * samples // blocks, (block + 1) * samples // blocks
        for rows, log_determinant in _rows(run, slice(first, last), readings, accelerations):
            gram += rows.T @ rows
            logarithm += log_determinant
        count = int(tangent.valid[first:last].sum())
        result.append(Whitened(gram=gram, logarithm=logarithm, readings=count))
    return result


def products(
    tangent: Tangent, disturbance: Disturbance, readings: Array, accelerations: Array, *, first: int
) -> tuple[Array, Array]:
    """Return the inner products of the first whitened columns with all, and the square of each.

    They cost less than the whole Gram matrix of many columns. See `whitened`, also for what is
    raised.

    Args:
        tangent: The linearised robot.
        disturbance: What else moves it, and the noise.
        readings: Direct change of each reading, shape (samples, channels, columns).
        accelerations: Acceleration by each column, per s2, shape (samples, dofs, columns).
        first: How many columns are the first.

    Returns:
        Shapes (first, columns) and (columns,).
    """
    samples, columns = len(tangent.jacobian), readings.shape[2]
    run = FilterRun(tangent, disturbance, columns)
    across, square = np.zeros((first, columns)), np.zeros(columns)
    for rows, _ in _rows(run, slice(0, samples), readings, accelerations):
        across += rows[:, :first].T @ rows
        square += np.einsum("ij,ij->j", rows, rows)
    return across, square


def _rows(
    run: FilterRun, part: slice, readings: Array, accelerations: Array | None
) -> Iterator[tuple[Array, float]]:
    """Yield whitened readings of some samples, (readings, columns), and their log determinant."""
    channels, columns = readings.shape[1:]
    length = max(1, CHUNK // (channels * columns))
    for begin in range(part.start, part.stop, length):
        some = slice(begin, min(begin + length, part.stop))
        moved = None if accelerations is None else accelerations[some]
        white, log_determinant = run.filter(some, readings[some], moved)
        there = run.tangent.valid[some]
        # Rows without a reading are zero: leaving them out is worth a copy where many are.
        yield (
            white[there] if there.mean() < 0.5 else white.reshape(-1, columns),
            log_determinant,
        )
