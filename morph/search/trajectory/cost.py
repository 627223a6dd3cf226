"""A task's cost as optimal control sees it: its values, and quadratics that bound it close by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.search.trajectory.plant import Plant
from morph.search.trajectory.tangent import moved_by
from morph.task.moved import Moved
from morph.task.task import Task
from morph.task.term import Goal, Term

AIM = 0.1
"""Weight of a goal's error, in what it allows, at the samples at which the goal is asked for."""

STEP = 1e-5
"""Half the distance of a difference, in the state's units and in the command's."""


@dataclass(frozen=True, kw_only=True)
class Quadratic:
    """The slope and the curvature of a cost in state and command, x = (q, v) and u.

    All have the leading axes (rows, samples); at the last sample the command costs nothing.
    """

    x: Array
    """Slope in the state, shape (..., n)."""
    u: Array
    """Slope in the command, shape (..., m)."""
    xx: Array
    """Curvature in the state, shape (..., n, n)."""
    uu: Array
    """Curvature in the command, shape (..., m, m)."""
    ux: Array
    """Curvature between the two, shape (..., m, n)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TaskCost:
    """The terms of a task, its goals while they are asked for, effort, and the worth of the end.

    A tip may be at the top of a chain that is folded: the goals alone say how links should stand.
    """

    task: Task
    """Whose terms cost."""
    plant: Plant
    """The body."""
    effort: float
    """What a command at its bound costs, a sample: effort / 2 (u / half its range)^2."""
    rest: Array
    """The command from which effort is counted, shape (nu,)."""
    goal: tuple[Array, Array]
    """The state to end in: position (nq,) and velocity (nv,)."""
    beyond: Array
    """The cost of all that follows the last state, 1/2 dx' beyond dx, shape (2 nv, 2 nv)."""

    def values(self, q: Array, v: Array, u: Array) -> Array:
        """Return what each sample costs, shape (rows, samples); no number is infinity.

        Args:
            q: Positions, shape (rows, samples, nq).
            v: Velocities, shape (rows, samples, nv).
            u: Commands, shape (rows, samples - 1, nu).
        """
        fine = np.asarray(np.isfinite(q).all((-2, -1)) & np.isfinite(v).all((-2, -1)))
        whole = fine[:, None, None]
        moved = self.moved(np.where(whole, q, self.plant.model.qpos0), np.where(whole, v, 0.0), u)
        total = sum(self.task.costs(moved).values(), start=np.zeros(q.shape[:-1]))
        for goal in self.task.goals:
            error, weight = _error(goal, moved)
            total += 0.5 * AIM * asked(goal, moved.time) * weight * np.sum(error**2, axis=-1)
        pressed = (u - self.rest) / self._half
        total[:, :-1] += 0.5 * self.effort * np.sum(pressed**2, axis=-1)
        dx = self.plant.off(q[:, -1], v[:, -1], *self.goal, wrapped=True)
        total[:, -1] += 0.5 * np.einsum("ri,ij,rj->r", dx, self.beyond, dx)
        return np.where(fine[:, None], total, np.inf)

    def moved(self, q: Array, v: Array, u: Array) -> Moved:
        """Return states and commands as the terms of a task look at them."""
        held = u if u.shape[-2] == q.shape[-2] else np.concatenate([u, u[..., -1:, :]], axis=-2)
        return Moved(
            robot=self.task.robot,
            model=self.plant.model,
            time=self._times(q),
            position=q,
            velocity=v,
            command=held,
        )

    def _times(self, q: Array) -> Array:
        return np.asarray(self.task.period * np.arange(q.shape[-2]), dtype=float)

    @property
    def _half(self) -> Array:
        return 0.5 * (self.plant.high - self.plant.low)

    def quadratic(self, q: Array, v: Array, u: Array) -> Quadratic:
        """Return a quadratic at every sample that touches the cost and, to first order, bounds it.

        Errors are linearised by differences, as Gauss and Newton do. The saturating cost is a
        concave function of |e|^2, so that its tangent in |e|^2 lies above it: its curvature is
        taken to be that of the tangent, which is never negative.

        The arguments are those of `values`.
        """
        total = quadratic_of(self.task.terms, self, q, v, u)
        time = self._times(q)
        for goal in self.task.goals:
            last = int(asked(goal, time).sum())
            held = u[:, -last + 1 :] if last > 1 else np.zeros((len(u), 1, u.shape[-1]))
            part = quadratic_of((goal,), self, q[:, -last:], v[:, -last:], held)
            for name, value in vars(part).items():
                getattr(total, name)[:, -last:] += AIM * value
        scale = self.effort / self._half**2
        total.u[:, :-1] += scale * (u - self.rest)
        total.uu[:, :-1] += np.diag(scale)
        dx = self.plant.off(q[:, -1], v[:, -1], *self.goal, wrapped=True)
        total.x[:, -1] += dx @ self.beyond
        total.xx[:, -1] += self.beyond
        return total


def quadratic_of(
    terms: tuple[Term | Goal, ...], cost: TaskCost, q: Array, v: Array, u: Array
) -> Quadratic:
    """Return the sum of the terms' quadratics; a goal counts as an error in widths of `within`.

    The arguments are those of `TaskCost.values`.
    """
    model, nv = cost.plant.model, cost.plant.model.nv
    n, m = 2 * nv, model.nu
    rows, samples = q.shape[:2]
    held = u if u.shape[1] == samples else np.concatenate([u, u[:, -1:]], axis=1)
    move = STEP * np.concatenate([np.eye(n + m), -np.eye(n + m), np.zeros((1, n + m))])
    move = move[None, :, None, :]
    shape = (rows, move.shape[1], samples)
    many = cost.moved(
        np.broadcast_to(moved_by(model, q[:, None], move[..., :nv]), (*shape, model.nq)),
        np.broadcast_to(v[:, None] + move[..., nv:n], (*shape, nv)),
        np.broadcast_to(held[:, None] + move[..., n:], (*shape, m)),
    )
    slope = np.zeros((rows, samples, n + m))
    curvature = np.zeros((rows, samples, n + m, n + m))
    for term in terms:
        error, weight = _error(term, many)
        e = error[:, -1]
        J = np.moveaxis(error[:, : n + m] - error[:, n + m : -1], 1, -1) / (2.0 * STEP)
        factor = weight * np.ones((rows, samples))
        if isinstance(term, Term) and term.norm == "saturating":
            factor = factor * np.exp(-0.5 * np.sum(e**2, axis=-1))
        slope += factor[..., None] * np.einsum("rsk,rskn->rsn", e, J)
        curvature += factor[..., None, None] * np.einsum("rskn,rskm->rsnm", J, J)
    return Quadratic(
        x=slope[..., :n],
        u=slope[..., n:],
        xx=curvature[..., :n, :n],
        uu=curvature[..., n:, n:],
        ux=curvature[..., n:, :n],
    )


def asked(goal: Goal, time: Array) -> Array:
    """Return 1 at the samples at which a goal is asked for, and 0 at others, shape (samples,)."""
    return np.asarray(time >= time[-1] - goal.last - 1e-9, dtype=float)


def _error(term: Term | Goal, moved: Moved) -> tuple[Array, Array]:
    """Return errors in widths, (..., samples, size), and the weight of each sample, (samples,)."""
    weight = np.ones(len(moved.time))
    if isinstance(term, Term):
        if term.last_only:
            weight[:-1] = 0.0
        return term.error(moved), term.weight * weight
    if not np.isfinite(term.within):
        return term.quantity.error(moved, term.target), 0.0 * weight
    return term.quantity.error(moved, term.target) / term.within, weight
