"""How plans do in a noisy closed loop, all of them in one batch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.arrays import Array, Mask
from morph.search.plan.initial_trajectories import SeedInputs
from morph.search.trajectory.ddp import Trajectories
from morph.search.trajectory.plant import Plant


def tried(
    ground: SeedInputs,
    plans: Trajectories,
    gain: Array,
    rows: int,
    rng: np.random.Generator,
    *,
    plant: Plant | None = None,
) -> tuple[Array, Mask]:
    """Return the losses of noisy runs under each plan, (plans, rows), and which succeed.

    Every run begins at a drawn start, and sees each number of its state through the task's
    noise: u = clip(command + sum over ages of gain (x + w - plan), low, high). All plans share
    the same draws, so that their differences are their own.

    Args:
        ground: The task and the body.
        plans: What to follow.
        gain: Feedback of each, shape (plans, periods + 1, m, ages, n).
        rows: Runs of each plan.
        rng: Chance.
        plant: The body that follows; that of the ground if none is given.
    """
    plant, task = plant or ground.plant, ground.cost.task
    many, periods, m = plans.command.shape
    cost = ground.cost if plant is ground.plant else replace(ground.cost, plant=plant)
    each = np.repeat(np.arange(many), rows)
    start = task.start.sample(task.robot, plant.model, rows, rng)
    n = 2 * plant.model.nv
    q = np.empty((len(each), periods + 1, plant.model.nq))
    v = np.empty((len(each), periods + 1, plant.model.nv))
    u = np.empty((len(each), periods, m))
    q[:, 0], v[:, 0] = np.tile(start[0], (many, 1)), np.tile(start[1], (many, 1))
    seen = np.zeros((len(each), gain.shape[3], n))
    for at in range(periods):
        noise = np.tile(rng.normal(scale=task.noise, size=(rows, n)), (many, 1))
        plan = plans.position[each, at], plans.velocity[each, at]
        dx = plant.off(q[:, at], v[:, at], *plan, wrapped=True) + noise
        seen[:, 1:] = seen[:, :-1].copy()
        seen[:, 0] = dx
        command = np.moveaxis(gain[:, at], 1, 0).reshape(m, many, 1, -1)
        back = (command * seen.reshape(many, rows, -1)).sum(-1).reshape(m, -1).T
        u[:, at] = np.clip(plans.command[each, at] + back, plant.low, plant.high)
        q[:, at + 1], v[:, at + 1] = plant.advance(q[:, at], v[:, at], u[:, at])
    fine = np.isfinite(q).all((1, 2)) & np.isfinite(v).all((1, 2))
    q[~fine], v[~fine], u[~fine] = ground.begin[0], ground.begin[1], 0.0
    moved = cost.moved(q, v, u)
    loss = np.where(fine, task.loss(moved), np.inf)
    success = task.succeeded(moved) & fine
    return loss.reshape(many, rows), success.reshape(many, rows)
