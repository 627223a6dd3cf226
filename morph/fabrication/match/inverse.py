"""Commands corrected by inverse dynamics: the same accelerations from the printed body."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np

from morph.arrays import Array
from morph.fabrication.match.case import Case
from morph.fabrication.match.matcher import Matcher
from morph.policy.adjusted import SOURCES, Adjusted, newest
from morph.policy.angles import features, turning
from morph.policy.observing import Observer, observations_of
from morph.policy.policy import Policy
from morph.search.evaluate import attempt
from morph.search.regulator.rest import driven, unlimited

RUNS, STATES = 4, 400
"""Noisy runs from which states are taken, and how many states."""

RIDGE = 1e-3
"""What a slope of 1 per spread costs, as a share of the weight of the states."""

BEYOND = 1.5
"""How far beyond what was met the law is taken to hold, in greatest sizes met."""

THINNEST = 1e-9
"""Spread of a number that does not vary."""


@dataclass(frozen=True, kw_only=True)
class InverseMatcher(Matcher):
    """u' = u + b + W z, by which the printed body accelerates as the designed one would.

    Along runs of the policy, M a + h = B u gives the acceleration a of the designed body and
    M' a + h' = B' u' the command u' of the printed one. A shift alone is what u' - u is at the
    runs' ends, where a servo is to stay; a law is fitted to all of it by least squares. Every
    joint must be driven: otherwise there is no such command.

    Source: Gamboa Higuera 2015, section 3.3, with both inverse dynamics known.
    """

    name: ClassVar[str] = "inverse dynamics"

    def suits(self, case: Case) -> bool:
        """Return whether every joint is driven, and the policy can be added to."""
        model: Any = case.bench.model
        free = model.nq == model.nv and not model.neq
        return bool(free and model.nu >= model.nv and type(case.learned) in SOURCES)

    def proposals(self, case: Case) -> Iterator[Policy]:
        """Yield a shift of the commands, and a law."""
        yield from corrected(case)


def corrected(case: Case) -> Iterator[Adjusted]:
    """Yield the policy with a shift that suits the printed body, and with a law."""
    task, simulator = case.designed, case.drawing_board
    rng = np.random.default_rng([case.seed, 1])
    moved = attempt(task, case.learned, simulator, rows=RUNS, rng=rng)
    position, velocity, command = (
        each.reshape(-1, each.shape[-1]) for each in (moved.position, moved.velocity, moved.command)
    )
    some = rng.permutation(len(position))[:STATES]
    # Of each run the last state comes first.
    last = np.arange(1, RUNS + 1) * len(moved.time) - 1
    some = np.concatenate([last, some])
    command = command[some]
    more = _wanted(case, position[some], velocity[some], command) - command
    observation = case.learned.observation or observations_of(task.robot, task.observes)
    angles = turning(task.robot, observation)
    blank = _added(case, observation, angles, inputs=None)
    at = newest(observation)
    seen = Observer(blank, task.robot, simulator.model, len(some)).see(
        position[some], velocity[some]
    )[:, at]
    z = np.concatenate([features(seen, *blank.seen), command], axis=1)
    none = np.zeros((command.shape[1], z.shape[1]))
    for law, bias in ((none, more[:RUNS].mean(axis=0)), _law(z, more)):
        yield _added(case, observation, angles, inputs=(law, bias, BEYOND * np.abs(z).max(axis=0)))


def _wanted(case: Case, position: Array, velocity: Array, command: Array) -> Array:
    """Return the commands of the printed body for the designed body's accelerations."""
    first: Any = case.drawing_board.model
    free = unlimited(case.bench.model)
    one, other = mujoco.MjData(first), mujoco.MjData(free)
    result = np.empty_like(command)
    for at in range(len(position)):
        one.qpos[:], one.qvel[:], one.ctrl[:] = position[at], velocity[at], command[at]
        mujoco.mj_forward(first, one)
        result[at], _ = driven(free, other, position[at], velocity[at], one.qacc)
    return result


def _law(z: Array, more: Array) -> tuple[Array, Array]:
    middle, spread = z.mean(axis=0), z.std(axis=0)
    varies = spread > THINNEST
    x = np.where(varies, (z - middle) / np.where(varies, spread, 1.0), 0.0)
    price = RIDGE * len(x) * np.eye(x.shape[1])
    slope = np.linalg.solve(x.T @ x + price, x.T @ (more - more.mean(axis=0)))
    law = (slope / np.where(varies, spread, 1.0)[:, None]).T
    return law, more.mean(axis=0) - law @ middle


def _added(
    case: Case,
    observation: Any,
    angles: Array,
    *,
    inputs: tuple[Array, Array, Array] | None,
) -> Adjusted:
    actions = len(case.learned.action)
    turns = int(np.asarray(angles)[newest(observation)].sum())
    size = len(observation) + turns + actions
    law, bias, reach = inputs or (np.zeros((actions, size)), np.zeros(actions), np.zeros(size))
    return Adjusted(
        source=case.learned,
        bias=bias,
        law=law,
        # One radial function of no weight: the law is all.
        centre=np.zeros((1, size)),
        width=np.ones((actions, size)),
        weight=np.zeros((actions, 1)),
        reach=reach,
        angles=angles,
        action=case.learned.action,
        period=case.learned.period,
        observation=observation,
    )
