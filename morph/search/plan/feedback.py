"""The feedback along a plan, made as the regulator at its end is: with the noise in mind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from morph.arrays import Array
from morph.search.plan.initial_trajectories import SeedInputs
from morph.search.plan.terminal_controller import aided
from morph.search.trajectory.backward import backward
from morph.search.trajectory.ddp import Trajectories
from morph.search.trajectory.linearise import linearise


def feedback(ground: SeedInputs, plans: Trajectories, effort: float) -> Array:
    """Return the gain at every period of every plan, shape (plans, periods, m, n).

    Of the linear-quadratic problem about the plan, its commands unbounded: where the plan
    presses against a bound, the feedback may still take the command back from it.

    Args:
        ground: The task and the body.
        plans: What is followed.
        effort: What the commands of the feedback cost, in costs of the regulator's.
    """
    plant = ground.plant
    A, B = linearise(plant, plans.position[:, :-1], plans.velocity[:, :-1], plans.command)
    here = aided(ground.cost, plans.position, plans.velocity, plans.command)
    half = 0.5 * (plant.high - plant.low)
    pressed = effort * ground.regulator.effort * (np.diag(half**-2.0) + here.uu)
    here = replace(here, x=np.zeros_like(here.x), u=np.zeros_like(here.u), uu=pressed)
    here.xx[:, -1] += ground.regulator.worth
    wide = np.full(plans.command.shape, np.inf)
    return backward(A, B, here, -wide, wide, np.zeros((len(plans.cost), plant.model.nu))).gain
