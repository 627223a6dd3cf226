"""Equilibrium of the learned dynamics and the feedback that stabilises it."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import torch
from scipy.optimize import least_squares

from morph.arrays import Array
from morph.errors import SearchError
from morph.search.learned_dynamics.learned_body import Dream
from morph.search.plan.initial_trajectories import SeedInputs
from morph.search.regulator.lqr import Regulator, lqr
from morph.search.regulator.rest import Rest
from morph.search.trajectory.cost import TaskCost, quadratic_of
from morph.search.trajectory.linearise import linearise
from morph.task.task import Task

NEAR = 1e-3
"""Pull towards the start's posture, for joints that no goal determines."""

EFFORT = 0.003
"""Cost of a command at its bound while a plan is improved: it only has to be convex."""

SOFT = 1e-3
"""Least cost of a joint's position, as a share of the greatest."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FeedbackCost:
    """What feedback makes small: 1/2 dx' state dx + rho/2 |command over its bound|^2."""

    still: Rest
    """Where to rest."""
    state: Array
    """Cost of the state, shape (2 nv, 2 nv)."""
    command: Array
    """Cost of the command at rho = 1, shape (nu, nu)."""
    slopes: tuple[Array, Array]
    """A and B of a period at rest."""
    where: str
    """What an error names as its place."""

    def regulator(self, rho: float) -> Regulator:
        """Return what holds the body at rest as far as is known.

        Early, when nothing was seen near the rest, the learned body may seem beyond control
        there; then nothing is fed back, and a plan ends where it ends.
        """
        n, m = self.slopes[1].shape
        if all(np.isfinite(each).all() for each in self.slopes):
            # What cannot be held as far as is known is not held.
            with suppress(SearchError):
                return lqr(*self.slopes, self.state, rho * self.command, where=self.where)
        return Regulator(
            gain=np.zeros((m, n)), worth=self.state, effort=float("nan"), noisy=float("nan")
        )


def aim(task: Task, dream: Dream) -> FeedbackCost:
    """Return where a task's goals are met, as far as kinematics tell, and what holds there.

    The command is the one by which the learned body accelerates least. A position costs what the
    goals' widths say, and a velocity what it changes a position by in a control period.
    """
    still = _still(task, dream)
    q, v, u = (a[None, None] for a in (still.position, still.velocity, still.command))
    cost = cost_of(task, dream, still, np.zeros((2 * dream.model.nv, 2 * dream.model.nv)))
    joints = dream.model.nv
    place = quadratic_of((*task.goals, *task.terms), cost, q, v, u).xx[0, 0, :joints, :joints]
    place = place + SOFT * max(float(np.diag(place).max()), 1.0) * np.eye(joints)
    state = np.zeros((2 * joints, 2 * joints))
    state[:joints, :joints] = place
    state[joints:, joints:] = dream.period**2 * np.diag(np.diag(place))
    half = 0.5 * (dream.high - dream.low)
    return FeedbackCost(
        still=still,
        state=state,
        command=np.diag(half**-2.0),
        slopes=linearise(dream.plant, still.position, still.velocity, still.command),
        where=f"task {task.name} of {task.robot.name}, as trials showed the body",
    )


def ground_of(
    task: Task, dream: Dream, aims: FeedbackCost, *, rho: float, margin: float
) -> SeedInputs:
    """Return what guesses and plans in a learned body stand on.

    Args:
        task: The task.
        dream: The learned body.
        aims: Where it is to rest.
        rho: The cost of effort of the regulator that takes over there.
        margin: Share of each command's range that is left free at both its ends.
    """
    regulator = aims.regulator(rho)
    q, v = task.start.sample(task.robot, dream.model, 1, None)
    return SeedInputs(
        cost=cost_of(task, dream, aims.still, regulator.worth),
        still=aims.still,
        regulator=regulator,
        begin=(q[0], v[0]),
        quick=dream.plant,
        margin=margin,
    )


def cost_of(task: Task, dream: Dream, still: Rest, beyond: Array) -> TaskCost:
    """Return a task's cost in a learned body, and what follows its last state."""
    return TaskCost(
        task=task,
        plant=dream.plant,
        effort=EFFORT,
        rest=still.command,
        goal=(still.position, still.velocity),
        beyond=beyond,
    )


def _still(task: Task, dream: Dream) -> Rest:
    joints, commands = dream.model.nv, dream.model.nu
    start, _ = task.start.sample(task.robot, dream.model, 1, None)
    nowhere = Rest(position=start[0], velocity=np.zeros(joints), command=np.zeros(commands))
    cost = cost_of(task, dream, nowhere, np.zeros((2 * joints, 2 * joints)))

    def residual(position: Array) -> Array:
        row = np.zeros((1, 1, joints))
        moved = cost.moved(position[None, None], row, np.zeros((1, 1, commands)))
        parts = [
            goal.quantity.error(moved, goal.target)[0, 0] / goal.within
            for goal in task.goals
            if np.isfinite(goal.within)
        ]
        return np.concatenate([*parts, NEAR * (position - start[0])])

    result = least_squares(residual, start[0] + 0.01, xtol=1e-12, ftol=1e-12, gtol=1e-12)
    position = np.asarray(result.x)
    return Rest(position=position, velocity=np.zeros(joints), command=_holding(dream, position))


def _holding(dream: Dream, position: Array) -> Array:
    """Return the command within its bounds by which a posture accelerates least, shape (nu,)."""
    many = dream.model.nu
    commanded = np.concatenate([np.zeros((1, many)), np.diag(dream.high)])
    q = torch.as_tensor(np.tile(position, (many + 1, 1)))
    with torch.no_grad():
        a = dream.learned.mean(q, torch.zeros_like(q), torch.as_tensor(commanded)).numpy()
    moment = (a[1:] - a[0]).T / dream.high
    command, *_ = np.linalg.lstsq(moment, -a[0], rcond=1e-3)
    return np.asarray(np.clip(command, dream.low, dream.high))
