"""A pattern: every actuator swings by the clock, or turns, or rests."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import PolicyError
from morph.policy.bound import Bound, bound_of
from morph.policy.fields import most_of
from morph.policy.policy import Action, Observation, Policy, actions_of

LARGEST = 1e6
"""Greatest number of a swing, in its unit."""


@dataclass(frozen=True, kw_only=True)
class Swing:
    """How one actuator moves: offset + rate t + amplitude sin(2 pi frequency t + phase).

    A paddle swings about an offset that steers it. A leg that turns has a rate of
    2 pi frequency, and the sine lets it dwell where it stands.

    Source: Meger, Gamboa Higuera, Xu and Dudek 2015, Learning Legged Swimming Gaits from
    Experience, ICRA: amplitude, frequency, offset and phase of each leg.
    """

    offset: float = 0.0
    """Middle of the swing, in the actuator's unit."""
    amplitude: float = 0.0
    """Farthest from the middle, in the actuator's unit."""
    frequency: float = 0.0
    """Swings a second, Hz."""
    phase: float = 0.0
    """Where in the swing the clock begins, rad."""
    rate: float = 0.0
    """How fast the middle moves, in the actuator's unit per s."""

    def __post_init__(self) -> None:
        """Check that every number is one."""
        for known in fields(self):
            value = getattr(self, known.name)
            if not abs(value) <= LARGEST:
                raise PolicyError(
                    f"{known.name} = {value:g} is no number from -{LARGEST:g} to {LARGEST:g}",
                    where="a swing",
                    fix="give a swing in rad (or m, N m, N) and Hz",
                )


NUMBERS = tuple(known.name for known in fields(Swing))
"""The numbers of a swing, in order."""


@dataclass(frozen=True, kw_only=True)
class Pattern(Policy):
    """A rhythm that needs no sensor: one swing for each actuator."""

    kind: ClassVar[str] = "pattern"

    swings: tuple[Swing, ...]
    """One for each action, in the same order."""

    def __post_init__(self) -> None:
        """Check that every actuator has its swing, and that nothing is observed."""
        super().__post_init__()
        if len(self.swings) != len(self.action) or self.observation:
            raise PolicyError(
                f"it has {len(self.swings)} swings for {len(self.action)} actions, "
                f"and {len(self.observation)} observations",
                where="a policy of kind pattern",
                fix="give one swing for each action, and no observation",
            )

    @cached_property
    def limited(self) -> Bound:
        """What keeps its commands within their bounds."""
        return bound_of(self.action, "clip", where="a policy of kind pattern")

    def act(self, observation: Array, time: Array) -> Array:
        """Return offset + rate t + amplitude sin(2 pi frequency t + phase), within bounds."""
        t = np.asarray(time, dtype=float)[..., None]
        n = self.weights()
        sine = np.sin(2.0 * math.pi * n["frequency"] * t + n["phase"])
        return self.limited(n["offset"] + n["rate"] * t + n["amplitude"] * sine)

    def weights(self) -> Mapping[str, Array]:
        """Return each number of the swings, shape (actions,)."""
        return {name: np.array([getattr(each, name) for each in self.swings]) for name in NUMBERS}

    @classmethod
    def of(
        cls,
        weights: Mapping[str, Array],
        *,
        action: tuple[Action, ...],
        period: float,
        observation: tuple[Observation, ...],
    ) -> Pattern:
        """Return the pattern that these numbers make."""
        shapes = {name: value.shape for name, value in weights.items()}
        if shapes != dict.fromkeys(NUMBERS, (len(action),)):
            raise PolicyError(
                f"its numbers have the shapes {most_of(shapes)}",
                where="a policy of kind pattern",
                fix=f"give {', '.join(NUMBERS)}, each of shape ({len(action)},)",
            )
        swings = tuple(
            Swing(**{name: float(weights[name][index]) for name in NUMBERS})
            for index in range(len(action))
        )
        return cls(swings=swings, action=action, period=period, observation=observation)


def pattern(robot: Robot, swings: Mapping[str, Swing], *, period: float = 0.01) -> Pattern:
    """Return a robot's pattern; actuators that are not named are told zero.

    Raises:
        RobotError: The robot has no actuator of a name.
    """
    for name in swings:
        robot.actuator(name)
    action = actions_of(robot)
    each = tuple(swings.get(known.actuator, Swing()) for known in action)
    return Pattern(swings=each, action=action, period=period)
