"""The family of policies: what each observes, what it commands, and when."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.policy.fields import most_of

UNLIMITED = 1e6
"""Bound of an action that nothing limits, in its unit: a leg may turn without end."""


LARGEST = 1e9
"""Greatest number that a policy holds, or sees: a greater one is seen as this one."""

MOST_HISTORY = 100
"""Most samples of one channel that are seen at once."""

MOST_SEEN = 10_000
"""Most numbers that are seen at once."""

LONGEST_DELAY = 10.0
"""Longest delay of a channel, s."""


@dataclass(frozen=True, kw_only=True)
class Observation:
    """One channel that a policy sees: (reading - offset) / scale.

    It gives as many numbers as its history is long, the newest first; before the first
    reading it is taken to have read the same. What a policy sees is these numbers of all
    its observations, one after another.
    """

    channel: str
    """Its name, as in a recording: `slide.position`."""
    unit: str
    """Its unit."""
    offset: float = 0.0
    """What is subtracted from a reading."""
    scale: float = 1.0
    """What the rest is divided by."""
    history: int = 1
    """How many samples it sees, this one and those before."""
    delay_s: float = 0.0
    """How old the newest sample is, s."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        right = {
            "offset": abs(self.offset) <= LARGEST,
            "scale": 1.0 / LARGEST <= abs(self.scale) <= LARGEST,
            "history": self.history in range(1, MOST_HISTORY + 1),
            "delay_s": 0.0 <= self.delay_s <= LONGEST_DELAY,
        }
        wrong = [name for name, holds in right.items() if not holds]
        if wrong:
            text = ", ".join(f"{name} = {getattr(self, name):g}" for name in wrong)
            raise PolicyError(
                f"{text} is out of range",
                where=f"observation {most_of(self.channel)}",
                fix=f"give an offset, a scale other than 0, a history of 1 to {MOST_HISTORY} "
                f"samples and a delay of 0 to {LONGEST_DELAY:g} s",
            )


@dataclass(frozen=True, kw_only=True)
class Action:
    """One actuator that a policy commands."""

    actuator: str
    """Its name in the description."""
    unit: str
    """Unit of the command: N m or N for a motor, rad or m for a servo."""
    low: float
    """The least command, which lesser ones become."""
    high: float
    """The greatest command."""

    def __post_init__(self) -> None:
        """Check the bounds."""
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low <= self.high):
            raise PolicyError(
                f"its bounds are {self.low:g} and {self.high:g} {self.unit}",
                where=f"action {self.actuator}",
                fix="give finite bounds, the lesser first",
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class Policy(ABC):
    """What tells every actuator of a body what to do."""

    kind: ClassVar[str]
    """What `policy.json` calls it."""

    action: tuple[Action, ...]
    """Every actuator of the body, in the body's order."""
    period: float = 0.01
    """How long each command is held, s."""
    observation: tuple[Observation, ...] = ()
    """What it sees; nothing if it runs by the clock alone."""

    def __post_init__(self) -> None:
        """Check the control period."""
        if not 1e-4 <= self.period <= 10.0:
            raise PolicyError(
                f"a control period of {self.period:g} s is out of range, 1e-4 to 10",
                where=f"a policy of kind {self.kind}",
                fix="take 0.01 s",
            )
        if self.size > MOST_SEEN:
            raise PolicyError(
                f"it sees {self.size} numbers at once",
                where=f"a policy of kind {self.kind}",
                fix=f"take shorter histories, at most {MOST_SEEN} numbers in all",
            )

    def __eq__(self, other: object) -> bool:
        """Return whether the other is of the same kind and says the same, number for number."""
        if type(other) is not type(self):
            return NotImplemented
        mine, its = self.weights(), other.weights()
        fields = ("action", "period", "observation")
        return (
            all(getattr(self, name) == getattr(other, name) for name in fields)
            and mine.keys() == its.keys()
            and all(np.array_equal(mine[name], its[name]) for name in mine)
        )

    __hash__ = None  # type: ignore[assignment]

    @property
    def size(self) -> int:
        """How many numbers it sees."""
        return sum(each.history for each in self.observation)

    @abstractmethod
    def act(self, observation: Array, time: Array) -> Array:
        """Return commands within their bounds, shape (..., actions).

        Args:
            observation: What it sees, shape (..., observations), `size` numbers each.
            time: The clock, s, shape (...,).
        """

    def typical(self, time: Array, rng: np.random.Generator) -> Array:
        """Return observations that it may meet at some times, (rows, observations).

        Small ones and great ones: the great alone would find every command at its bound.
        """
        shape = (len(time), self.size)
        return np.asarray(rng.normal(size=shape) * 10.0 ** rng.uniform(-3.0, 0.0, size=shape))

    @abstractmethod
    def weights(self) -> Mapping[str, Array]:
        """Return all its numbers by name, as `weights.safetensors` holds them."""

    @classmethod
    @abstractmethod
    def of(
        cls,
        weights: Mapping[str, Array],
        *,
        action: tuple[Action, ...],
        period: float,
        observation: tuple[Observation, ...],
    ) -> Policy:
        """Return the policy that these numbers make.

        Raises:
            PolicyError: A number is missing or more than that, or their shapes are wrong.
        """

    def by_clock(self, actuator: str, times: Array) -> Array:
        """Return what an actuator is told at each time, s, if nothing need be observed.

        A command holds from one multiple of the control period to the next; shape (steps,).

        Raises:
            PolicyError: The policy observes, or commands no such actuator.
        """
        if self.observation:
            seen = ", ".join(each.channel for each in self.observation)
            raise PolicyError(
                f"it observes {seen}, and cannot run by the clock alone",
                where=f"a policy of kind {self.kind}",
                fix="run it in a closed loop",
            )
        names = [each.actuator for each in self.action]
        if actuator not in names:
            raise PolicyError(
                f"it commands {', '.join(names)}, not {actuator!r}",
                where=f"a policy of kind {self.kind}",
                fix="name one of these actuators",
            )
        # A step may begin a rounding error before the command that is due.
        held = self.period * np.floor(np.asarray(times, dtype=float) / self.period + 1e-6)
        return np.asarray(self.act(np.empty((*held.shape, 0)), held)[..., names.index(actuator)])

    def commands(self) -> Mapping[str, Callable[[Array], Array]]:
        """Return what `Simulator.run(command=...)` takes.

        Raises:
            PolicyError: The policy observes.
        """
        if self.observation:
            self.by_clock("", np.zeros(0))
        return {each.actuator: partial(self.by_clock, each.actuator) for each in self.action}


def actions_of(robot: Robot) -> tuple[Action, ...]:
    """Return an action for every actuator of a robot, bounded as its joint or its effort is."""
    actions = []
    for actuator in robot.actuators:
        if actuator.kind == "position":
            joint = robot.driven_by(actuator)
            unit, bounds = joint.unit, joint.limits
        else:
            unit, limit = actuator.effort_unit, actuator.limit
            bounds = None if limit is None else (-limit, limit)
        low, high = bounds or (-UNLIMITED, UNLIMITED)
        low, high = max(low, -UNLIMITED), min(high, UNLIMITED)
        actions.append(Action(actuator=actuator.name, unit=unit, low=low, high=high))
    return tuple(actions)
