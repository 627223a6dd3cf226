"""Plans and regulators as policies that can be stored."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from morph.arrays import Integers
from morph.body.robot import Robot
from morph.errors import SearchError
from morph.policy.angles import turning
from morph.policy.linear import Linear
from morph.policy.observing import addresses, observations_of
from morph.policy.policy import actions_of
from morph.policy.track import Track
from morph.search.plan.initial_trajectories import SeedInputs
from morph.search.plan.plan_selection import Planned
from morph.search.regulator.lqr import Regulator
from morph.search.regulator.rest import Rest
from morph.search.trajectory.plant import Plant
from morph.search.trajectory.tangent import apart
from morph.task.task import Task


def track_of(ground: SeedInputs, result: Planned) -> Track:
    """Return a plan as a policy; beyond its end the regulator holds the state of rest.

    Raises:
        SearchError: The body floats: a plan's feedback knows hinges and slides alone.
    """
    plant, task = ground.plant, ground.cost.task
    column = columns(plant.robot, plant.model, task.observes)
    plan = result.plan
    # The state of rest, so many turns on that the plan's end is near.
    end = plan.position[0, -1]
    goal = end - apart(plant.model, end, ground.still.position, wrapped=True)
    position = np.concatenate([plan.position[0, :-1], goal[None]])
    velocity = np.concatenate([plan.velocity[0, :-1], ground.still.velocity[None]])
    state = np.concatenate([position, velocity], axis=1)[:, column]
    gain = result.gain[..., column]
    ages = 1 + int(np.flatnonzero(np.abs(gain).max((0, 1, 3)) > 0.0).max(initial=0))
    knots, actions = gain.shape[:2]
    # Of each channel all its ages, the newest first: at knot k and age a that of knot k - a.
    past = np.maximum(np.arange(knots)[:, None] - np.arange(ages), 0)
    past[-1] = knots - 1
    seen = tuple(
        replace(each, history=ages) for each in observations_of(plant.robot, task.observes)
    )
    return Track(
        nominal=np.swapaxes(state[past], 1, 2).reshape(knots, -1),
        command=np.concatenate([plan.command[0], ground.still.command[None]]),
        gain=np.swapaxes(gain[:, :, :ages], 2, 3).reshape(knots, actions, -1),
        angles=turning(plant.robot, seen),
        action=actions_of(plant.robot),
        period=task.period,
        observation=seen,
    )


def linear_of(task: Task, plant: Plant, still: Rest, regulator: Regulator) -> Linear:
    """Return a regulator as a policy.

    A hinge without limits is seen by its sine and cosine: k sin(angle - angle0) is the feedback
    near rest, and does not mind full turns.

    Raises:
        SearchError: The body floats: the feedback knows hinges and slides alone.
    """
    column = columns(plant.robot, plant.model, task.observes)
    seen = observations_of(plant.robot, task.observes)
    angles = turning(plant.robot, seen)
    gain = regulator.gain[:, column]
    rest = np.concatenate([still.position, still.velocity])[column]
    plain, turns = angles == 0.0, angles == 1.0
    sine, cosine = np.cos(rest[turns]) * gain[:, turns], -np.sin(rest[turns]) * gain[:, turns]
    both = np.stack([sine, cosine], axis=-1).reshape(len(gain), -1)
    return Linear(
        weight=np.concatenate([gain[:, plain], both], axis=1),
        bias=still.command - gain[:, plain] @ rest[plain],
        angles=angles,
        action=actions_of(plant.robot),
        period=task.period,
        observation=seen,
    )


def columns(robot: Robot, model: Any, channels: tuple[str, ...] | None) -> Integers:
    """Return where each observation stands in the state (q, v) of hinges and slides.

    Raises:
        SearchError: The body floats, or a number of its state cannot be seen.
    """
    where = f"a plan for {robot.name}"
    if model.nq != model.nv:
        raise SearchError(
            "a plan's feedback knows hinges and slides alone, and this body floats",
            where=where,
            fix="take a search that does not plan, such as cmaes",
        )
    known = addresses(robot, model)
    names = [each.channel for each in observations_of(robot, channels)]
    missing = set(range(2 * model.nv)) - {known[name] for name in names}
    if missing:
        blind = [name for name, at in known.items() if at in missing]
        raise SearchError(
            f"a plan's feedback needs the whole state, and the task does not let it see "
            f"{', '.join(blind) or 'all of it'}",
            where=where,
            fix="let the task observe every joint, or search for a policy that needs less",
        )
    return np.array([known[name] for name in names], dtype=np.int64)
