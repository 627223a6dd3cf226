"""A task as moment matching takes it: angles, costs, observations and start distribution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from morph.arrays import Array, Integers
from morph.errors import SearchError
from morph.model.gp.gp import GaussianProcess
from morph.policy.angles import turning
from morph.policy.bound import limits
from morph.policy.observing import observations_of
from morph.policy.policy import UNLIMITED, Action, Observation, actions_of
from morph.search.gp_rollout.belief import GPPlant
from morph.search.moments.moment_matching_rff import Lift, Squash
from morph.search.moments.moments import ProcessMoments
from morph.search.moments.saturating import ExpectedCost
from morph.task.moved import Moved
from morph.task.task import Task
from morph.task.term import Term

PROBES = 400
"""Postures at which it is tried whether a term is linear in sines and cosines."""

FAR, NEAR = 2.5, 0.3
"""How far postures are tried, rad or m: anywhere, and about the start."""

EXACT = 1e-6
"""Greatest error, in widths, of a term that is."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TaskSums:
    """A task as sums over the numbers of z = (q, v, sin a, cos a)."""

    task: Task
    """The task."""
    lift: Lift
    """The angles a: each hinge that turns freely, and sums of them if a cost needs them."""
    costs: tuple[ExpectedCost, ...]
    """The terms of the cost."""
    sees: Integers
    """Which of z the policy sees, in the order of the features of policies with feedback."""
    looks: Integers
    """Which of (z, u) accelerations depend on."""
    observation: tuple[Observation, ...]
    """What the policy observes: every position and velocity."""
    action: tuple[Action, ...]
    """What it commands."""
    angles: Array
    """Which observations are angles, as policies take it."""
    start: tuple[Array, Array]
    """Mean and covariance of the first state."""

    @property
    def joints(self) -> int:
        """How many joints there are."""
        return len(self.start[0]) // 2

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The least and the greatest commands, shape (actions,) each."""
        return limits(self.action)

    def lifted(self, state: Array) -> Array:
        """Return z of states (..., 2 joints)."""
        angle = state @ self.lift.angles.T
        return np.concatenate([state, np.sin(angle), np.cos(angle)], axis=-1)

    def plant(self, process: GaussianProcess) -> GPPlant:
        """Return what is believed of the body, from its change of velocity in a period."""
        return GPPlant(
            process=ProcessMoments(process),
            looks=self.looks,
            sees=self.sees,
            lift=self.lift,
            squash=Squash(*self.bounds),
            noise=np.zeros(self.joints),
            blur=np.full(len(self.sees), self.task.noise**2),
            period=self.task.period,
        )


def view_of(task: Task) -> TaskSums:
    """Return how a task looks to moment matching.

    Raises:
        SearchError: The body has joints that are neither hinge nor slide, a command without
            bounds, or a term of the task is not linear in positions, velocities, sines and
            cosines.
    """
    where = f"task {task.name} of {task.robot.name}"
    model = task.simulator().model
    if model.nq != model.nv or any(j.kind not in {"hinge", "slide"} for j in task.robot.joints):
        raise SearchError(
            "moment matching knows hinges and slides, and this body has other joints",
            where=where,
            fix="take another search",
        )
    action = actions_of(task.robot)
    free = [each.actuator for each in action if each.high >= UNLIMITED]
    if free:
        raise SearchError(
            f"nothing limits {', '.join(free)}", where=where, fix="give limits in the body's card"
        )
    observation = observations_of(task.robot)
    angles = turning(task.robot, observation)
    lift, costs = _costs(task, model, np.flatnonzero(angles), where)
    joints, turn = model.nv, np.flatnonzero(angles)
    plain = np.flatnonzero(angles == 0.0)
    k = len(lift.angles)
    waves = np.array([[2 * joints + i, 2 * joints + k + i] for i in range(len(turn))], dtype=int)
    command = lift.size + np.arange(model.nu)
    limited = [
        i for i, j in enumerate(task.robot.joints) if j.kind == "hinge" and i not in set(turn)
    ]
    q, v = task.start.sample(task.robot, model, 1, None)
    return TaskSums(
        task=task,
        lift=lift,
        costs=costs,
        sees=np.concatenate([plain, waves.ravel()]).astype(np.int64),
        looks=np.concatenate([limited, joints + np.arange(joints), waves.ravel(), command]).astype(
            np.int64
        ),
        observation=observation,
        action=action,
        angles=angles,
        start=(np.concatenate([q[0], v[0]]), task.start.spread**2 * np.eye(2 * joints)),
    )


def _costs(
    task: Task, model: Any, turn: Integers, where: str
) -> tuple[Lift, tuple[ExpectedCost, ...]]:
    """Return the least lift in which every term is linear, and the terms.

    An angle's error is wrapped, which no linear function is. About a start that is far from
    where it jumps it is taken without: so a task to balance is served.
    """
    single = np.zeros((len(turn), 2 * model.nv))
    single[np.arange(len(turn)), turn] = 1.0
    sums = np.concatenate([single, np.cumsum(single, axis=0)[1:]])
    start, _ = task.start.sample(task.robot, model, 1, None)
    tries = [
        (angles, _probes(task, model, middle, reach))
        for middle, reach in ((np.zeros(model.nq), FAR), (start[0], NEAR))
        for angles in (single, sums)
    ]
    lost = ""
    for angles, probes in tries:
        lift = Lift(angles)
        results = [_linear(term, probes, lift, where) for term in task.terms]
        if all(cost is not None for cost in results):
            return lift, tuple(cost for cost in results if cost is not None)
        lost = task.terms[results.index(None)].name
    raise SearchError(
        f"term {lost!r} is no linear function of positions, velocities, sines and cosines",
        where=where,
        fix="take another search, or a term that is: a point of a planar chain, a speed",
    )


def _probes(task: Task, model: Any, middle: Array, reach: float) -> Moved:
    """Return chance postures, speeds and no commands: kinematics, and nothing of the motion."""
    rng = np.random.default_rng(0)
    return Moved(
        robot=task.robot,
        model=model,
        time=np.zeros(1),
        position=middle + rng.uniform(-reach, reach, size=(PROBES, 1, model.nq)),
        velocity=rng.uniform(-FAR, FAR, size=(PROBES, 1, model.nv)),
        command=np.zeros((PROBES, 1, model.nu)),
    )


def _linear(term: Term, probes: Moved, lift: Lift, where: str) -> ExpectedCost | None:
    """Return a term as a function of z, or None if it is not linear."""
    if term.last_only:
        raise SearchError(
            f"term {term.name!r} counts at the end alone",
            where=where,
            fix="give a term that counts always",
        )
    state = np.concatenate([probes.position, probes.velocity], axis=-1)[:, 0]
    angle = state @ lift.angles.T
    z = np.concatenate([state, np.sin(angle), np.cos(angle), np.ones((len(state), 1))], axis=1)
    error = term.error(probes)[:, 0]
    result = np.linalg.lstsq(z, error, rcond=None)[0]
    if np.abs(z @ result - error).max() > EXACT:
        return None
    # What least squares leaves of nothing would only cost time.
    result[np.abs(result) < 1e-9] = 0.0
    return ExpectedCost(A=result[:-1].T, b=result[-1], weight=term.weight, norm=term.norm)
