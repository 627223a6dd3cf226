"""Choose plan and feedback by expected cost over posterior samples of the dynamics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from morph.arrays import Array, Integers
from morph.model.jointed.draws import Draws
from morph.policy.angles import turning
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of
from morph.policy.track import Track
from morph.search.learned_dynamics.learned_body import Dream, stepped
from morph.search.learned_dynamics.rest_feedback import FeedbackCost
from morph.search.trajectory.backward import backward
from morph.search.trajectory.cost import Quadratic
from morph.search.trajectory.ddp import Trajectories
from morph.search.trajectory.linearise import linearise
from morph.task.moved import Moved
from morph.task.task import Task


@dataclass(frozen=True, kw_only=True, eq=False)
class Plans:
    """Plans with feedback: u = clip(command + gain (x - state)), one knot a control period.

    The last knot is the rest, where what is held after the horizon.
    """

    state: Array
    """Positions and velocities, shape (plans, knots, 2 nv)."""
    command: Array
    """Shape (plans, knots, nu)."""
    gain: Array
    """Shape (plans, knots, nu, 2 nv)."""

    def rows(self, which: Integers | slice) -> Plans:
        """Return some of them."""
        return Plans(state=self.state[which], command=self.command[which], gain=self.gain[which])

    def track(self, at: int, task: Task) -> Track:
        """Return one of them as a policy."""
        observation = observations_of(task.robot)
        return Track(
            nominal=self.state[at],
            command=self.command[at],
            gain=self.gain[at],
            angles=turning(task.robot, observation),
            action=actions_of(task.robot),
            observation=observation,
            period=task.period,
        )


def joined(parts: Sequence[Plans]) -> Plans:
    """Return the plans of several, one after another."""
    return Plans(
        state=np.concatenate([each.state for each in parts]),
        command=np.concatenate([each.command for each in parts]),
        gain=np.concatenate([each.gain for each in parts]),
    )


def with_feedback(
    dream: Dream, aims: FeedbackCost, paths: Trajectories, rhos: Sequence[float]
) -> Plans:
    """Return paths, each with the feedback that is best for each cost of effort.

    Along a path it is the regulator of the linear body that changes with time, in which a
    command at its bound stays free: u = clip(command + gain dx) makes the best of what is left.
    """
    n, (rows, periods, m) = 2 * dream.model.nv, paths.command.shape
    A, B = linearise(dream.plant, paths.position[:, :-1], paths.velocity[:, :-1], paths.command)
    wide = np.full(paths.command.shape, np.inf)
    parts = []
    for rho in rhos:
        held = aims.regulator(rho)
        xx = np.tile(aims.state, (rows, periods + 1, 1, 1))
        xx[:, -1] = held.worth
        law = backward(
            A,
            B,
            Quadratic(
                x=np.zeros((rows, periods + 1, n)),
                u=np.zeros((rows, periods + 1, m)),
                xx=xx,
                uu=np.tile(rho * aims.command, (rows, periods + 1, 1, 1)),
                ux=np.zeros((rows, periods + 1, m, n)),
            ),
            -wide,
            wide,
            np.zeros((rows, m)),
        )
        rest = np.concatenate([aims.still.position, aims.still.velocity])
        state = np.concatenate([paths.position, paths.velocity], axis=-1)
        state[:, -1] = rest
        last = np.broadcast_to(held.gain, (rows, 1, m, n))
        stay = np.broadcast_to(aims.still.command, (rows, 1, m))
        parts.append(
            Plans(
                state=state,
                command=np.concatenate([paths.command, stay], axis=1),
                gain=np.concatenate([law.gain, last], axis=1),
            )
        )
    return joined(parts)


@dataclass(frozen=True, kw_only=True)
class PlanPredictions:
    """How plans do in the bodies that the data allow."""

    loss: Array
    """Mean loss of each plan, shape (plans,)."""
    success: Array
    """Share of bodies in which it reaches every goal, shape (plans,)."""


def foreseen(
    task: Task,
    dream: Dream,
    draws: Draws,
    plans: Plans,
    noise: Array,
    rng: np.random.Generator,
) -> PlanPredictions:
    """Return how plans do in closed loop, each once in each drawn body.

    Plans share the bodies, the starts and the noise, so that their differences are their own.

    Args:
        task: The task.
        dream: The body.
        draws: Bodies drawn from what is believed.
        plans: What is tried.
        noise: Standard deviation of each observation, shape (2 nv,).
        rng: Chance.
    """
    bodies, many = draws.count, len(plans.command)
    joints = dream.model.nv
    q0, v0 = task.start.sample(task.robot, dream.model, bodies, rng)
    blur = torch.as_tensor(rng.standard_normal((task.samples, bodies, 1, 2 * joints)) * noise)
    q = torch.as_tensor(q0)[:, None].expand(-1, many, -1)
    v = torch.as_tensor(v0)[:, None].expand(-1, many, -1)
    turns = torch.as_tensor(2.0 * np.pi * (dream.model.jnt_type == 3))
    state, command, gain = (torch.as_tensor(a) for a in (plans.state, plans.command, plans.gain))
    low, high = torch.as_tensor(dream.low), torch.as_tensor(dream.high)
    seen_q, seen_v, commanded = [q], [v], []
    with torch.no_grad():
        for at in range(task.samples - 1):
            dx = torch.cat([q, v], dim=-1) + blur[at] - state[:, at]
            angle = dx[..., :joints]
            whole = torch.where(turns > 0.0, torch.round(angle / (2.0 * np.pi)), 0.0)
            dx = torch.cat([angle - 2.0 * np.pi * whole, dx[..., joints:]], dim=-1)
            u = command[:, at] + (gain[:, at] @ dx[..., None])[..., 0]
            u = torch.minimum(torch.maximum(u, low), high)
            q, v = stepped(draws.accelerate, (q, v), u, dream.period)
            seen_q.append(q)
            seen_v.append(v)
            commanded.append(u)
    moved = Moved(
        robot=task.robot,
        model=dream.model,
        time=np.asarray(task.period * np.arange(task.samples), dtype=float),
        position=torch.stack(seen_q, dim=2).numpy(),
        velocity=torch.stack(seen_v, dim=2).numpy(),
        command=torch.stack([*commanded, commanded[-1]], dim=2).numpy(),
    )
    return PlanPredictions(loss=task.loss(moved).mean(0), success=task.succeeded(moved).mean(0))
