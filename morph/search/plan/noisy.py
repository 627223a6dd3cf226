"""How plans do in a noisy closed loop, all of them in one batch."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array, Mask
from morph.search.plan.seeds import Ground
from morph.search.trajectory.ddp import Trajectories


def tried(
    ground: Ground, plans: Trajectories, gain: Array, rows: int, rng: np.random.Generator
) -> tuple[Array, Mask]:
    """Return the losses of noisy runs under each plan, (plans, rows), and which succeed.

    Every run begins at a drawn start, and sees each number of its state through the task's
    noise: u = clip(command + gain (x + w - plan), low, high). All plans share the same draws, so
    that their differences are their own.

    Args:
        ground: The task and the body.
        plans: What to follow.
        gain: Feedback of each, shape (plans, periods, m, n).
        rows: Runs of each plan.
        rng: Chance.
    """
    plant, task = ground.plant, ground.cost.task
    many, periods, m = plans.command.shape
    each = np.repeat(np.arange(many), rows)
    start = task.start.sample(task.robot, plant.model, rows, rng)
    n = 2 * plant.model.nv
    q = np.empty((len(each), periods + 1, plant.model.nq))
    v = np.empty((len(each), periods + 1, plant.model.nv))
    u = np.empty((len(each), periods, m))
    q[:, 0], v[:, 0] = np.tile(start[0], (many, 1)), np.tile(start[1], (many, 1))
    for at in range(periods):
        noise = np.tile(rng.normal(scale=task.noise, size=(rows, n)), (many, 1))
        plan = plans.position[each, at], plans.velocity[each, at]
        dx = plant.off(q[:, at], v[:, at], *plan, wrapped=True) + noise
        back = (gain[each, at] @ dx[..., None])[..., 0]
        u[:, at] = np.clip(plans.command[each, at] + back, plant.low, plant.high)
        q[:, at + 1], v[:, at + 1] = plant.advance(q[:, at], v[:, at], u[:, at])
    fine = np.isfinite(q).all((1, 2)) & np.isfinite(v).all((1, 2))
    q[~fine], v[~fine], u[~fine] = ground.begin[0], ground.begin[1], 0.0
    moved = ground.cost.moved(q, v, u)
    loss = np.where(fine, task.loss(moved), np.inf)
    success = task.succeeded(moved) & fine
    return loss.reshape(many, rows), success.reshape(many, rows)
