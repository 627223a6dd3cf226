"""Terminal controller of a plan: equilibrium, regulator and cost-to-go there."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.search.plan.initial_trajectories import SeedInputs
from morph.search.regulator.lqr import Regulator, noise_aware
from morph.search.regulator.rest import Rest, rest
from morph.search.trajectory.cost import Quadratic, TaskCost, quadratic_of
from morph.search.trajectory.linearise import linearise
from morph.search.trajectory.plant import Plant
from morph.sim.simulator import Simulator
from morph.task.task import Task

AID = 0.01
"""Share of the goals' errors that is added to the terms, so that a plan also succeeds."""

CALM = 1e-4
"""Cost of every number of the state, so that nothing drifts unseen."""

EFFORT = 0.003
"""Cost of a command at its bound while a plan is improved: it only has to be convex."""


FEWER = {"rk4": 0.4, "implicitfast": 0.2}
"""Steps of a control period in which guesses are drawn, as a share of the simulator's."""


def grounded(
    task: Task, simulator: Simulator, *, margin: float, rng: np.random.Generator
) -> SeedInputs:
    """Return what a plan for a task stands on.

    Raises:
        SearchError: The body cannot rest where its goals are met, or nothing holds it there.
        SimulationFailed: The task's control period does not fit the simulator.
    """
    plant = Plant(simulator, task.period)
    still = rest(task, plant, rng)
    regulator = held(task, plant, still)
    q, v = task.start.sample(task.robot, plant.model, 1, None)
    return SeedInputs(
        cost=_cost(task, plant, still, regulator.worth),
        still=still,
        regulator=regulator,
        begin=(q[0], v[0]),
        quick=Plant(_coarser(simulator, plant), task.period),
        margin=margin,
    )


def _coarser(simulator: Simulator, plant: Plant) -> Simulator:
    steps = max(2, round(FEWER[simulator.integrator] * plant.substeps))
    return Simulator(
        simulator.robot,
        simulator.effects,
        step=plant.period / min(steps, plant.substeps),
        integrator=simulator.integrator,
    )


def held(task: Task, plant: Plant, still: Rest) -> Regulator:
    """Return the regulator that holds a body at rest under the task's noise.

    Raises:
        SearchError: A motion grows there that no command moves.
    """
    n, m = 2 * plant.model.nv, plant.model.nu
    A, B = linearise(plant, still.position, still.velocity, still.command)
    cost = _cost(task, plant, still, np.zeros((n, n)))
    state = still.position[None, None], still.velocity[None, None], still.command[None, None]
    here = aided(cost, *state)
    half = 0.5 * (plant.high - plant.low)
    return noise_aware(
        A,
        B,
        here.xx[0, 0],
        np.diag(half**-2.0) + here.uu[0, 0],
        np.full(n, task.noise),
        where=f"task {task.name} of {task.robot.name}",
        bounds=np.broadcast_to(half, (m,)),
    )


def aided(cost: TaskCost, q: Array, v: Array, u: Array) -> Quadratic:
    """Return the quadratic by which feedback is made: of the terms, the goals, and calm."""
    terms = quadratic_of(cost.task.terms, cost, q, v, u)
    goals = quadratic_of(cost.task.goals, cost, q, v, u)
    xx = terms.xx + AID * goals.xx + CALM * np.eye(terms.xx.shape[-1])
    return Quadratic(x=terms.x, u=terms.u, xx=xx, uu=terms.uu, ux=terms.ux)


def _cost(task: Task, plant: Plant, still: Rest, worth: Array) -> TaskCost:
    return TaskCost(
        task=task,
        plant=plant,
        effort=EFFORT,
        rest=still.command,
        goal=(still.position, still.velocity),
        beyond=worth,
    )
