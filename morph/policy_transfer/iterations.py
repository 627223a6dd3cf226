"""One body made again and again: every time its lengths, masses and motors come out otherwise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from morph.alignment.samples import Transitions
from morph.arrays import Array
from morph.body.robot import Robot
from morph.body.vary import Heavier, Operation, Scale, vary
from morph.errors import MorphError, TransferError
from morph.physics.actuator.torque_scale import TorqueScale
from morph.policy_transfer.body import Body, body
from morph.policy_transfer.linear_belief import LinearBelief
from morph.task.push import Push
from morph.task.task import Task

NEAR = (0.2, 1.5)
"""Farthest from rest, rad or m, and per s, that a run goes on: beyond, no linear law holds."""

SHARE = 0.2
"""Standard deviation of random commands in half ranges, as `Body.transitions` counts them."""

TRIES = 20
"""How often a change is drawn anew if the body that comes of it cannot rest."""

STEP = 1e-3
"""Distance of a finite difference, in logarithms."""

SURE = 1e-3
"""How well the numbers of the body that is described are known, in logarithms."""


@dataclass(frozen=True, kw_only=True)
class Drift:
    """How far one change goes: standard deviations of logarithms."""

    lengths: float = 0.08
    """Of each link that turns on a hinge, at its density: its mass goes with the cube."""
    masses: float = 0.15
    """Of each link, beside what its length does."""
    motors: float = 0.2
    """Of the gain of each actuator."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name, value in vars(self).items():
            if not 0.0 < value <= 1.0:
                raise TransferError(
                    f"{name} = {value:g} is out of range, above 0 to 1",
                    where="a drift from body to body",
                    fix="give the standard deviation of a logarithm, such as 0.1",
                )


@dataclass(frozen=True, kw_only=True, eq=False)
class PrintedBody:
    """A described body of which no two copies are alike: numbers w tell what a copy has become.

    Each is the logarithm of what a length, a mass or a motor has come to be over what is
    described, so that w = 0 is the description and changes of changes add.
    """

    described: Robot
    """The body."""
    pose: Callable[[Robot], Task]
    """From a body to its task."""
    push: Push
    """By which every run begins."""
    drift: Drift
    """How far one change goes."""

    @cached_property
    def numbers(self) -> tuple[tuple[str, str], ...]:
        """Each number: what changes (`length`, `mass` or `motor`), and of which part."""
        turned = {joint.link for joint in self.described.joints if joint.kind == "hinge"}
        links = [each for each in self.described.links if each.mass > 0.0]
        return (
            *(("length", each.name) for each in links if each.name in turned),
            *(("mass", each.name) for each in links),
            *(("motor", each.name) for each in self.described.actuators),
        )

    @cached_property
    def spread(self) -> Array:
        """Standard deviations of one change, shape (numbers,)."""
        far = {
            "length": self.drift.lengths,
            "mass": self.drift.masses,
            "motor": self.drift.motors,
        }
        return np.array([far[kind] for kind, _ in self.numbers])

    def body(self, changes: Array, *, name: str = "") -> Body:
        """Return the body with its task as such numbers make it, shape (numbers,).

        Raises:
            RobotError: A link cannot be changed so.
            SearchError: It can rest nowhere.
        """
        operations: list[Operation] = []
        effects: list[TorqueScale] = []
        for (kind, part), change in zip(self.numbers, np.exp(changes).tolist(), strict=True):
            if kind == "length":
                operations.append(Scale(link=part, factor=change))
            elif kind == "mass":
                operations.append(Heavier(link=part, factor=change))
            else:
                effects.append(TorqueScale(actuator=part, gain=change))
        robot = vary(self.described, *operations)
        # Ten changes told in a name are a page.
        task = self.pose(replace(robot, name=name or self.described.name))
        start = replace(task.start, push=self.push)
        return body(replace(task, start=start, effects=(*task.effects, *effects)))

    def linear(self, changes: Array) -> tuple[Array, Array]:
        """Return [A B] of such a body, and its derivative by the numbers, as a `Model` does."""
        size = len(changes)
        moves = np.concatenate([np.zeros((1, size)), STEP * np.eye(size)])
        made = [np.concatenate(self.body(changes + move).linear, axis=1) for move in moves]
        slopes = [(each - made[0]).ravel() / STEP for each in made[1:]]
        return made[0], np.stack(slopes, axis=1)

    def known(self) -> LinearBelief:
        """Return what the description tells: the first body is as it says."""
        size = len(self.numbers)
        sure = SURE**2 * np.eye(size)
        return LinearBelief(model=self.linear, mean=np.zeros(size), covariance=sure)


def iterations(printed: PrintedBody, *, count: int, rng: np.random.Generator) -> tuple[Array, ...]:
    """Return what so many bodies have become, each a change by chance of the one before.

    Raises:
        TransferError: None of many changes left a body that can rest.
    """
    results: list[Array] = []
    now = np.zeros(len(printed.numbers))
    for _ in range(count):
        now = _next(printed, now, rng)
        results.append(now)
    return tuple(results)


def _next(printed: PrintedBody, now: Array, rng: np.random.Generator) -> Array:
    for _ in range(TRIES):
        after = now + printed.spread * rng.standard_normal(len(now))
        try:
            printed.body(after)
        except MorphError as error:
            hindered = error
        else:
            return np.asarray(after)
    raise TransferError(
        f"none of {TRIES} changes left a body that can rest: {hindered.what}",
        where=f"iterations of {printed.described.name}",
        fix="let a change go less far",
    ) from hindered


def nearby(
    made: Body, count: int, rng: np.random.Generator, *, share: float = SHARE
) -> Transitions:
    """Return so many transitions of random commands near rest, seen through the task's noise.

    A run begins as the task does, without its push, and ends as soon as it is no longer NEAR
    rest: a chain that folds tells nothing of how it stands.

    Args:
        made: The body.
        count: How many transitions; all that it made are among them.
        rng: The chance of starts, commands and noise.
        share: Standard deviation of the commands, in half ranges.
    """
    low, high = made.bounds
    half = 0.5 * np.minimum(high - low, 2.0 * np.pi)
    start = replace(made.task.start, push=None)
    begins = made.state(*start.sample(made.task.robot, made.plant.model, count, rng))
    command = np.clip(share * half * rng.standard_normal((count, len(half))), low, high)
    noise = made.task.noise * rng.standard_normal((2, count, made.size))
    near = np.repeat(NEAR, made.size // 2)
    state, after = np.empty((2, count, made.size))
    x, seen = begins[0], begins[0] + noise[0, 0]
    for row in range(count):
        if (np.abs(x) > near).any():
            x, seen = begins[row], begins[row] + noise[0, row]
        state[row] = seen
        x = made.step(x[None], command[row][None])[0]
        seen = x + noise[1, row]
        after[row] = seen
    return Transitions(
        state=state, command=command, after=after, turns=np.zeros(made.size, dtype=bool)
    )


def first_of(seen: Transitions, count: int) -> Transitions:
    """Return the first so many transitions."""
    return Transitions(
        state=seen.state[:count],
        command=seen.command[:count],
        after=seen.after[:count],
        turns=seen.turns,
    )
