"""State distributions as vectors: their transition, cost and derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.special import erf

from morph.arrays import Array, Integers
from morph.model.gp.gp import GaussianProcess
from morph.search.gp_rollout.belief import GPPlant
from morph.search.gp_rollout.laws import LinearLaw, Unsquashed
from morph.search.gp_rollout.task import TaskSums
from morph.search.moments.saturating import expected
from morph.search.trajectory.cost import Quadratic

MEAN_STEP = 1e-4
"""Half the distance of a difference in a mean, in its unit."""

SPREAD_STEP = 1e-6
"""The same in a covariance."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Beliefs:
    """What is believed at each control time, and the law that leads there; leading axes: rows."""

    mean: Array
    """Shape (rows, samples, d)."""
    covariance: Array
    """Shape (rows, samples, d, d)."""
    command: Array
    """The mean command, shape (rows, periods, m)."""
    gain: Array
    """K of u = command + K (x - mean), shape (rows, periods, m, d)."""
    cost: Array
    """Shape (rows,)."""

    def row(self, at: int) -> Beliefs:
        """Return one of them, with its axis."""
        return Beliefs(**{name: value[at : at + 1] for name, value in vars(self).items()})


@dataclass(frozen=True, kw_only=True, eq=False)
class BeliefPlant:
    """A body as what is believed of it: b = (mean, upper half of the covariance).

    Source: Pan and Theodorou 2014, Probabilistic Differential Dynamic Programming, NIPS,
    section 2.2. The covariance goes on under the feedback that will be there, and not without
    any, as it does in that paper: what cannot stand without feedback would else be lost at once.
    """

    view: TaskSums
    """The task."""
    plant: GPPlant
    """What is believed of the body, its law being of the state as it is observed."""
    effort: float
    """What a command at its bound costs, a sample: effort / 2 (u / half its range)^2."""

    @cached_property
    def upper(self) -> tuple[Integers, Integers]:
        """Which entries of the covariance stand in b."""
        rows, columns = np.triu_indices(len(self.view.start[0]))
        return rows.astype(np.int64), columns.astype(np.int64)

    @cached_property
    def _each(self) -> tuple[Array, Array]:
        """The unit vectors of b, as means and symmetric covariances, (numbers, 1, d[, d])."""
        d, (rows, columns) = len(self.view.start[0]), self.upper
        count = d + len(rows)
        mean, covariance = np.zeros((count, 1, d)), np.zeros((count, 1, d, d))
        mean[np.arange(d), 0, np.arange(d)] = 1.0
        at = np.arange(d, count)
        covariance[at, 0, rows, columns] = 1.0
        covariance[at, 0, columns, rows] = 1.0
        return mean, covariance

    def vector(self, mean: Array, covariance: Array) -> Array:
        """Return b, shape (..., numbers)."""
        rows, columns = self.upper
        return np.concatenate([mean, covariance[..., rows, columns]], axis=-1)

    def _flat(self, mean: Array, covariance: Array) -> Array:
        """Return the slope in b from those in mean and (symmetric) covariance."""
        rows, columns = self.upper
        twice = np.where(rows == columns, 1.0, 2.0)
        return np.concatenate([mean, twice * covariance[..., rows, columns]], axis=-1)

    def after(self, m: Array, S: Array, u: Array, K: Array) -> tuple[Array, Array]:
        """Return mean and covariance a period later, of rows of beliefs."""
        law = LinearLaw(K, u - (K @ m[..., None])[..., 0])
        mean, covariance, _ = self.plant.forward(m, S, law)
        return mean, covariance

    def felt(self, S: Array, K: Array, room: Array) -> Array:
        """Return the share of a gain that bounded commands leave of it, shape (rows, m).

        A command that is Gaussian with the deviation s is within a bound that lies r away with
        the probability erf(r / (s sqrt 2)), which also is E[du/dr] of the clipped command, if
        both bounds are that far.

        Args:
            S: Covariance of the state, shape (rows, d, d).
            K: The gain, shape (rows, m, d).
            room: r, shape (rows, m).
        """
        spread = S + np.diag(self.plant.blur)
        deviation = np.sqrt(np.maximum(((K @ spread) * K).sum(axis=-1), 1e-12))
        return np.asarray(erf(np.maximum(room, 0.0) / (math.sqrt(2.0) * deviation)))

    def widened(self, by: float) -> BeliefPlant:
        """Return the same with costs that are felt from farther off."""
        costs = tuple(replace(c, A=c.A / by, b=c.b / by) for c in self.view.costs)
        return replace(self, view=replace(self.view, costs=costs))

    def slopes(self, beliefs: Beliefs) -> tuple[Array, Array]:
        """Return A and B of db' = A db + B du at each period of one row.

        Shapes (1, periods, numbers, numbers) and (1, periods, numbers, m).
        """
        m, S = beliefs.mean[0, :-1], beliefs.covariance[0, :-1]
        u, K = beliefs.command[0], beliefs.gain[0]
        law = LinearLaw(K, u - (K @ m[..., None])[..., 0])
        _, _, tape = self.plant.forward(m, S, law)
        mean, covariance = self._each
        # An entry of a symmetric matrix stands twice in it; its adjoint is shared between both.
        shared = covariance / np.maximum(covariance.sum(axis=(-2, -1), keepdims=True), 1.0)
        count, periods = len(mean), len(m)
        nothing = np.zeros(())
        into_m, into_S, numbers = self.plant.backward(
            tape,
            law,
            np.broadcast_to(mean, (count, periods, m.shape[-1])),
            np.broadcast_to(shared, (count, *S.shape)),
            nothing,
            nothing,
        )
        into_u = numbers[..., -u.shape[-1] :]
        # The law's mean follows the mean of the state; the slope wanted holds the command.
        into_m = into_m - (into_u[..., None, :] @ K)[..., 0, :]
        A = self._flat(into_m, into_S)
        return np.swapaxes(A, 0, 1)[None], np.swapaxes(into_u, 0, 1)[None]

    def costs(self, mean: Array, covariance: Array, command: Array) -> Array:
        """Return the expected cost of rows of beliefs, shape (rows,)."""
        z, C, _ = self.view.lift.forward(mean, covariance)
        total = expected(self.view.costs, z, C)[0].sum(axis=-1)
        return np.asarray(total + 0.5 * (self._stiff * command**2).sum(axis=(-2, -1)))

    @cached_property
    def _stiff(self) -> Array:
        low, high = self.view.bounds
        return np.asarray(self.effort / (0.5 * (high - low)) ** 2)

    def _slope(self, m: Array, S: Array) -> Array:
        """Return the slope in b of what a belief costs, shape (..., numbers)."""
        z, C, tape = self.view.lift.forward(m, S)
        _, into_z, into_C = expected(self.view.costs, z, C)
        return self._flat(*self.view.lift.backward(tape, into_z, into_C))

    def quadratic(self, beliefs: Beliefs) -> Quadratic:
        """Return slope and curvature of the cost along one row; the curvature is never negative."""
        m, S, u = beliefs.mean[0], beliefs.covariance[0], beliefs.command[0]
        mean, covariance = self._each
        d, size = m.shape[-1], u.shape[-1]
        step = np.full(len(mean), SPREAD_STEP)
        step[:d] = MEAN_STEP
        dm, dS = step[:, None, None] * mean, step[:, None, None, None] * covariance
        more, less = self._slope(m + dm, S + dS), self._slope(m - dm, S - dS)
        H = np.moveaxis((more - less) / (2.0 * step[:, None, None]), 0, -1)
        # Weighted by the steps the numbers are of one size, which means and covariances are not.
        scale = step / MEAN_STEP
        values, vectors = np.linalg.eigh(0.5 * (H + H.mT) * scale * scale[:, None])
        H = (vectors * np.maximum(values, 0.0)[..., None, :]) @ vectors.mT / scale / scale[:, None]
        lead = (1, len(m))
        last = np.zeros((1, 1, size))
        return Quadratic(
            x=self._slope(m, S)[None],
            u=np.concatenate([(self._stiff * u)[None], last], axis=1),
            xx=H[None],
            uu=np.broadcast_to(np.diag(self._stiff), (*lead, size, size)),
            ux=np.zeros((*lead, size, len(mean))),
        )


def belief_plant(view: TaskSums, process: GaussianProcess, effort: float) -> BeliefPlant:
    """Return a body as what is believed of it under laws of its state."""
    d = len(view.start[0])
    plant = replace(
        view.plant(process),
        sees=np.arange(d),
        blur=np.full(d, view.task.noise**2),
        squash=Unsquashed(),
    )
    return BeliefPlant(view=view, plant=plant, effort=effort)
