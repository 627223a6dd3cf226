"""The family that everything acting on a body joins: one effect, its parameters, its faces."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.errors import EffectError
from morph.physics.motion import Motion
from morph.physics.simulations import Simulations as Simulations

Some = TypeVar("Some", bound="Effect")


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """What is known of one parameter of an effect before any data."""

    name: str
    """Its symbol in the effect's law."""
    unit: str
    """SI; `-` for a pure number."""
    default: float
    """The value when nothing is said."""
    low: float
    """The least value allowed."""
    high: float
    """The greatest value allowed."""
    neutral: float | None
    """The value at which the effect does nothing; None for a shape that has none."""
    scan: tuple[float, ...]
    """Values to try where a gradient misleads: delays, and shapes of curves."""
    free: bool
    """Whether a diagnosis may move it; geometry that is known stays."""
    spread: float | None
    """How far from neutral it is likely to be; None: anywhere within its bounds."""

    @property
    def reciprocal(self) -> bool:
        """Whether it does nothing at infinity, and else as much as one over it."""
        return self.neutral == UNLIMITED


def parameter(
    default: float,
    *,
    unit: str,
    low: float,
    high: float,
    neutral: float | None = None,
    scan: tuple[float, ...] = (),
    free: bool = True,
    spread: float | None = None,
) -> Any:
    """Return a dataclass field that is a parameter of an effect."""
    known = {"unit": unit, "low": low, "high": high, "neutral": neutral, "scan": scan, "free": free}
    known["spread"] = spread
    return field(default=default, metadata=known)


SLIDING = {
    "N m": "N",
    "N m s/rad": "N s/m",
    "N m s2/rad2": "N s2/m2",
    "N m/rad": "N/m",
    "rad": "m",
    "rad/s": "m/s",
    "kg m2": "kg",
    "1/rad": "1/m",
    "1/(N m)": "1/N",
}
"""What the unit of a parameter becomes on a slide."""

UNLIMITED = 1e9
"""A limit that nothing reaches and a stiffness that nothing bends."""


class Effect(ABC):
    """One piece of physics that a simulation may have or lack.

    Every subclass is a frozen dataclass in a file of its own, listed in `morph.physics.EFFECTS`.
    """

    name: ClassVar[str]
    """Its name in the vocabulary of left-out physics."""
    kind: ClassVar[str]
    """The kind of part it acts on: joint, actuator, sensor, body, contact or world."""
    strengths: ClassVar[tuple[str, ...]]
    """The parameters in which its generalized force is linear."""
    dissipative: ClassVar[bool] = False
    """Whether it can only take energy away."""
    holds: ClassVar[bool] = False
    """Whether it is dry friction, which holds a joint at rest whatever drives it, up to a level."""
    stands_for: ClassVar[tuple[str, ...]] = ()
    """Kinds of figures of its own part that the description need no longer be refitted in."""
    simpler: ClassVar[str] = ""
    """The effect that it becomes when its extra parameters have no say."""
    twins: ClassVar[tuple[str, ...]]
    """Effects that look alike on poor data."""
    excited_by: ClassVar[str]
    """What a recording must hold for it to be seen."""
    separate_by: ClassVar[Mapping[str, str]] = {}
    """The experiment that tells it from a twin, by the twin's name."""
    suspected: ClassVar[bool] = True
    """Whether a search for a latent force (`morph.model.latent`) looks for it."""
    everywhere: ClassVar[bool] = False
    """Whether it is the same at all of its places: it is told at one of them."""
    of_a_run: ClassVar[bool] = False
    """Whether it is looked for in each run by itself."""

    @property
    @abstractmethod
    def where(self) -> str:
        """The name of the part it acts on."""

    @abstractmethod
    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence, in N and m where its joint is a slide."""

    @classmethod
    @abstractmethod
    def at(cls: type[Some], where: str) -> Some:
        """Return the effect at a part, its parameters neutral or at their defaults."""

    @classmethod
    @abstractmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the names of the parts of a robot on which it can act."""

    @classmethod
    def suspects(cls, robot: Robot) -> tuple[str, ...]:
        """Return the places at which a search for a latent force looks for it."""
        return cls.places(robot) if cls.suspected else ()

    def __post_init__(self) -> None:
        """Check every parameter against its bounds."""
        for known in self.parameters():
            value = getattr(self, known.name)
            if not (math.isfinite(value) and known.low <= value <= known.high):
                raise EffectError(
                    f"{known.name} = {value:g} {known.unit} is outside "
                    f"{known.low:g} to {known.high:g}",
                    where=f"effect {self.name}@{self.where}",
                    fix=f"give {known.name} a value within these bounds",
                )

    @classmethod
    def parameters(cls) -> tuple[Parameter, ...]:
        """Return its parameters in the order of their definition."""
        return tuple(
            Parameter(name=item.name, default=float(item.default), **item.metadata)  # type: ignore[arg-type]
            for item in fields(cls)  # type: ignore[arg-type]
            if "unit" in item.metadata
        )

    @classmethod
    def free(cls) -> tuple[Parameter, ...]:
        """Return the parameters that a diagnosis may move."""
        return tuple(known for known in cls.parameters() if known.free)

    @property
    def label(self) -> str:
        """Its name and place, as `coulomb_friction@shoulder`."""
        return f"{self.name}@{self.where}"

    @property
    def stepped(self) -> bool:
        """Whether it must act before every step because MuJoCo cannot hold it."""
        return type(self).before_step is not Effect.before_step

    @property
    def remembers(self) -> bool:
        """Whether what it does depends on more than the state that MuJoCo knows."""
        return (
            type(self).initial_state is not Effect.initial_state
            or type(self).command is not Effect.command
        )

    @property
    def outside(self) -> bool:
        """Whether MuJoCo cannot hold it: it acts before every step or changes signals."""
        own, none = type(self), Effect
        changes_readings = own.sense is not none.sense or own.stamp is not none.stamp
        return self.stepped or own.command is not none.command or changes_readings

    @property
    def passing(self) -> bool:
        """Whether it is an event of one run, which no simulation repeats."""
        return False

    def neutral(self: Some) -> Some:
        """Return the effect with every strength at the value that does nothing."""
        idle = {p.name: p.neutral for p in self.parameters() if p.neutral is not None}
        return replace(self, **idle)  # type: ignore[type-var]

    def edit(self, spec: Any) -> None:
        """Write into a `mujoco.MjSpec` what MuJoCo can hold by itself."""

    def initial_state(self, simulations: Simulations) -> Any:
        """Return the internal state that `before_step` is handed, here none."""
        return None

    def recalled(self, motion: Motion) -> Array:
        """Return its internal state along a recording, (..., samples), if it remembers long."""
        raise NotImplementedError

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Act on every simulation for the coming step; return the new internal state.

        In a batch the parameters are arrays of shape (simulations,).
        """
        return state

    def command(self, actuator: str, command: Array, step: float) -> Array:
        """Return what an actuator receives when `command` is sent; (..., steps) each."""
        return command

    def sense(self, channel: str, reading: Array) -> Array:
        """Return what a sensor reports when `reading` is true; (..., samples) each."""
        return reading

    def stamp(self, channel: str, time: Array) -> Array:
        """Return the times, s, that a recording says for readings taken at `time`."""
        return time

    @abstractmethod
    def regressor(self, motion: Motion) -> Array:
        """Return its generalized force along a recording for strengths of one.

        Shape (samples, dofs, strengths): the force is this times `coefficients`, to first order.
        """

    def reading_regressor(self, motion: Motion) -> Array:
        """Return how it changes readings along a recording, likewise for strengths of one.

        Shape (samples, channels of the motion, strengths); zero unless it is a sensor's.
        """
        return np.zeros((*motion.reading.shape, len(self.strengths)))

    def shapes(self, motion: Motion) -> tuple[Effect, ...]:
        """Return the effect at a few values of the parameters in which it is not linear.

        By default those to scan; laws whose scale is the recording's take them from it.
        """
        scanned = [p for p in self.parameters() if p.scan and p.name not in self.strengths]
        grid = itertools.product(*(p.scan for p in scanned))
        names = [p.name for p in scanned]
        return tuple(replace(self, **dict(zip(names, values, strict=True))) for values in grid)  # type: ignore[type-var]

    def extent(self, motion: Motion) -> float:
        """Return how far a recording excites it, in any unit; by default all alike."""
        return 0.0

    def beside(self, other: Effect) -> bool:
        """Return whether both may act at once."""
        return True

    @classmethod
    def regressors(cls: type[Some], shapes: Sequence[Some], motion: Motion) -> Array:
        """Return the regressors at several shapes, (samples, dofs, strengths of all shapes)."""
        return np.concatenate([effect.regressor(motion) for effect in shapes], axis=2)

    @property
    def coefficients(self) -> Array:
        """What the columns of its regressor are multiplied by, shape (strengths,)."""
        idle = {p.name: p.neutral or 0.0 for p in self.parameters()}
        return np.array([getattr(self, name) - idle[name] for name in self.strengths])

    def coefficient_bounds(self) -> tuple[Array, Array]:
        """Return the least and the greatest of its coefficients, shape (strengths,) each.

        Unbounded where an effect defines its coefficients otherwise.
        """
        if type(self).coefficients is not Effect.coefficients:
            size = len(self.strengths)
            return np.full(size, -np.inf), np.full(size, np.inf)
        known = {p.name: p for p in self.parameters()}
        pairs = [(known[name], known[name].neutral or 0.0) for name in self.strengths]
        low = np.array([p.low - neutral for p, neutral in pairs])
        return low, np.array([p.high - neutral for p, neutral in pairs])

    def simplified(self, law: Some) -> Some:
        """Return the law of the name `simpler` as it stands for this one, to begin a fit with."""
        return law.with_strengths(self.coefficients[:1])

    def with_strengths(self: Some, coefficients: Array) -> Some:
        """Return the effect with strengths read off a linear fit, kept in bounds."""
        known, values = {p.name: p for p in self.parameters()}, {}
        for name, value in zip(self.strengths, coefficients, strict=True):
            p = known[name]
            values[name] = float(np.clip((p.neutral or 0.0) + value, p.low, p.high))
        return replace(self, **values)  # type: ignore[type-var]
