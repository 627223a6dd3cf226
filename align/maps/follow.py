"""From a map of states to one of commands: the target is told what lets it follow the source.

Source: Ammar, Eaton, Ruvolo and Taylor 2015, AAAI, section 4 (the target's first policy tracks
what the source would do, seen through the map of states); least squares over a short horizon on
linear models of both bodies is ours.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError, SamplesError, SettingError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import MapData, Mapper
from morph.alignment.maps.state_law import StateLaw
from morph.alignment.samples import Transitions

RIDGE = 1e-3
"""What a slope of one spread costs in the linear models, as a share of the data."""

FLAT = 1e-8
"""Least share of the largest spread that a number of the source must have as seen by the map."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearDynamics:
    """x' = A x + B u + c."""

    A: Array
    """Shape (n, n)."""
    B: Array
    """Shape (n, k)."""
    c: Array
    """Shape (n,)."""


def linear(seen: Transitions) -> LinearDynamics:
    """Return the linear model of a body that its transitions make most likely, by ridge.

    Raises:
        SamplesError: There are fewer transitions than the model has numbers for each state.
    """
    m, n = seen.state.shape
    inputs = np.concatenate([seen.state, seen.command], axis=1)
    if m < inputs.shape[1] + 2:
        raise SamplesError(
            f"there are {m} transitions",
            where="a linear model of a body",
            fix=f"give at least {inputs.shape[1] + 2}",
        )
    middle, spread = inputs.mean(axis=0), inputs.std(axis=0)
    spread = np.where(spread > 1e-9, spread, 1.0)
    z, move = (inputs - middle) / spread, seen.after - seen.state
    slope = np.linalg.solve(
        z.T @ z + RIDGE * m * np.eye(z.shape[1]), z.T @ (move - move.mean(axis=0))
    )
    law = (slope / spread[:, None]).T
    c = move.mean(axis=0) - law @ middle
    return LinearDynamics(A=law[:, :n] + np.eye(n), B=law[:, n:], c=c)


def followed(
    states: StateLaw, source: Transitions, target: Transitions, *, horizon: int, effort: float
) -> AffineMap:
    """Return the map whose commands make the target follow the source over a horizon.

    With the source at x = S y + s and its command held, x_1, x_2, ... follow by its linear model.
    The target's commands a_0, a_1, ... make
    sum_h |(y_h - L x_h - l) / spread|^2 + effort sum_h |a_h / spread|^2 least by its own, and
    a_0 = W u + E y + w. The lift L x + l is the mean of the target's states that are seen as x.

    Args:
        states: S and s.
        source: What the source did.
        target: What the target did.
        horizon: How many periods.
        effort: What a command of one spread costs against one spread of a state.

    Raises:
        MapError: Two numbers of the source are seen as one: the map cannot be inverted.
        SamplesError: There are too few transitions.
    """
    ours, theirs = linear(source), linear(target)
    lift, lift_shift = lifted(states, target.state)
    n, k = ours.B.shape
    m, kt = theirs.B.shape
    weight = 1.0 / np.where(target.state.std(axis=0) > 1e-9, target.state.std(axis=0), 1.0)
    spread = target.command.std(axis=0)
    spread = np.where(spread > 1e-9, spread, 1.0)
    # Columns of the source: x, u and 1; of the target: y and 1, and what each command moved.
    seen = np.concatenate([np.eye(n), np.zeros((n, k + 1))], axis=1)
    free = np.concatenate([np.eye(m), np.zeros((m, 1))], axis=1)
    command = np.zeros((m, horizon * kt))
    drive, wanted, by_itself = [], [], []
    for h in range(horizon):
        seen, free = ours.A @ seen, theirs.A @ free
        seen[:, n:] += np.column_stack([ours.B, ours.c])
        free[:, -1] += theirs.c
        command = theirs.A @ command
        command[:, h * kt : (h + 1) * kt] += theirs.B * spread
        there = lift @ seen
        there[:, -1] += lift_shift
        drive.append(weight[:, None] * command)
        wanted.append(weight[:, None] * there)
        by_itself.append(weight[:, None] * free)
    G = np.concatenate(drive)
    price = effort * np.eye(horizon * kt)
    first = spread[:, None] * np.linalg.solve(G.T @ G + price, G.T)[:kt]
    from_source, from_target = first @ np.concatenate(wanted), first @ np.concatenate(by_itself)
    by_state, W, rest = np.split(from_source, [n, n + k], axis=1)
    E = by_state @ states.S - from_target[:, :m]
    w = rest[:, 0] + by_state @ states.s - from_target[:, m]
    R = np.linalg.pinv(W)
    return AffineMap(
        state_law=states.S, state_shift=states.s, lift_law=lift, lift_shift=lift_shift,
        action_law=W, action_state=E, action_shift=w,
        read_law=R, read_state=-R @ E, read_shift=-R @ w,
    )  # fmt: skip


def lifted(states: StateLaw, target: Array) -> tuple[Array, Array]:
    """Return L and l: the mean of a target's states, were they normal, that are seen as x.

    L = Q S' inv(S Q S') with Q their covariance, and S (L x + l) + s = x.

    Raises:
        MapError: S Q S' has no inverse.
    """
    middle = target.mean(axis=0)
    Q = np.atleast_2d(np.cov(target.T))
    seen = states.S @ Q @ states.S.T
    size = np.sqrt(np.maximum(np.diag(seen), 0.0))
    alike = seen / np.maximum(np.outer(size, size), 1e-300)
    if size.min() <= 0.0 or np.linalg.eigvalsh(alike).min() < FLAT:
        raise MapError(
            f"the target's {target.shape[1]} numbers are seen as fewer than the source's "
            f"{len(states.S)}",
            where="a map of states",
            fix="give a target that moves in as many ways as the source, or more pairs",
        )
    lift = np.linalg.solve(seen, states.S @ Q).T
    return np.asarray(lift), np.asarray(middle - lift @ (states.S @ middle + states.s))


@dataclass(frozen=True, kw_only=True)
class Following(Mapper):
    """A mapper that learns a map of states, and has the target follow the source through it."""

    horizon: int = 30
    """How many periods the target is to follow."""
    effort: float = 0.4
    """What a command of one spread costs against one spread of a state."""

    def __post_init__(self) -> None:
        """Check the settings."""
        if not (1 <= self.horizon <= 200 and self.effort > 0.0):
            raise SettingError(
                f"the horizon is {self.horizon} periods and effort costs {self.effort:g}",
                where=f"map {self.name}",
                fix="give a horizon of 1 to 200 and a positive effort",
            )

    def estimate(self, given: MapData, rng: np.random.Generator) -> AffineMap:
        """Return the map of states with commands that follow."""
        return followed(
            self.states(given, rng),
            given.source,
            given.target,
            horizon=self.horizon,
            effort=self.effort,
        )

    @abstractmethod
    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return how the target's states are seen as the source's."""
