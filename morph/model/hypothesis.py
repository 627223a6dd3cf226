"""A robot under effects with every uncertain figure free: a point is a simulation."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.follow import QUICK, RIGID
from morph.body.fulltext import fulltext
from morph.body.robot import Robot
from morph.body.spec import spec_of
from morph.model.nuisance_parameters import Knob
from morph.physics.body.external_push import ExternalPush
from morph.physics.body.point import PointEffect
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.contact.pairs import pairs_of
from morph.physics.contact.spring import effective_masses
from morph.physics.effect import Effect, Parameter
from morph.sim.rollout import Variant
from morph.sim.simulator import compiled

POINT = ("cx", "cy", "cz")
"""Parameters that say where on its link an effect acts."""
HEAVY, FADES = 1e6, 0.01
"""Inertia that holds a joint, kg m2 or kg, and seconds in which its velocity fades."""
EDGES, STABLE = (0.0, -1.0), 0.9
"""Values at which laws of contact do nothing; and the stiffest, as a share of what a step takes."""
ROUGH = 0.1
"""Step of differences by a parameter of a contact, as a share of it: impacts have edges."""
BARE: dict[tuple[str, str, float], Any] = {}
"""Specs without what does not move a robot, by hash and name of the robot and step."""


def bare_spec(robot: Robot, step: float) -> Any:
    """Return a robot's `mujoco.MjSpec` without shapes that touch nothing; copy it to edit.

    Every step of MuJoCo places every shape, and looks for islands among constraints: on
    small robots that takes a third of the time and changes no motion. Joints that follow others
    do so rigidly, as they do along a recording.
    """
    key = (robot.sha256 or robot.mjcf, robot.name, step)
    if key not in BARE:
        spec = spec_of(robot, timestep=step)
        for geom in list(spec.geoms):
            if geom.contype == 0 and geom.conaffinity == 0:
                spec.delete(geom)
        used = {geom.meshname for geom in spec.geoms}
        for mesh in [each for each in spec.meshes if each.name not in used]:
            spec.delete(mesh)
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND.value
        try:
            spec.compile()
            # Files that it was read with would be held in memory anew by every candidate.
            text = fulltext(spec)
            kept = {name: content for name, content in robot.assets.items() if name in text}
            spec = mujoco.MjSpec.from_string(text, assets=kept)
        except ValueError:
            # A tendon or a pair refers to a shape: keep them all.
            spec = spec_of(robot, timestep=step)
        for tie in (each for each in spec.equalities if each.type == mujoco.mjtEq.mjEQ_JOINT):
            tie.solimp, tie.solref = RIGID, QUICK
        BARE[key] = spec
    return BARE[key]


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """A robot, what may be wrong in its description, and effects to be fitted.

    A point holds the logarithms of the knobs' factors, then the effects' parameters: of a limit
    or a stiffness, which does nothing at infinity, one over it.
    """

    robot: Robot
    """The nominal description."""
    step: float
    """Seconds a step of simulation."""
    knobs: tuple[Knob, ...]
    """Figures of the description that are refitted."""
    effects: tuple[Effect, ...] = ()
    """Effects whose parameters are fitted; their values are where a fit starts."""
    held: tuple[str, ...] = ()
    """Joints that never move, whatever forces act on them: what holds them is not the links."""

    @cached_property
    def _slots(self) -> tuple[tuple[int, Any], ...]:
        return tuple(
            (index, known) for index, effect in enumerate(self.effects) for known in effect.free()
        )

    @cached_property
    def names(self) -> tuple[str, ...]:
        """What each entry of a point is called."""
        of_effects = tuple(f"{self.effects[i].label}:{known.name}" for i, known in self._slots)
        return tuple(knob.name for knob in self.knobs) + of_effects

    @property
    def size(self) -> int:
        """The number of entries of a point."""
        return len(self.knobs) + len(self._slots)

    @cached_property
    def start(self) -> Array:
        """The nominal description with the effects as they stand."""
        values = [entry(known, getattr(self.effects[i], known.name)) for i, known in self._slots]
        return np.array([0.0] * len(self.knobs) + values)

    @cached_property
    def low(self) -> Array:
        """The least value of each entry."""
        ends = [(k, *self._ends(at, k)) for at, k in self._slots]
        least = [entry(k, high if k.reciprocal else low) for k, low, high in ends]
        return np.array([self._bounds(k)[0] for k in self.knobs] + least)

    @cached_property
    def high(self) -> Array:
        """The greatest value of each entry."""
        ends = [(k, *self._ends(at, k)) for at, k in self._slots]
        most = [entry(k, low if k.reciprocal else high) for k, low, high in ends]
        return np.array([self._bounds(k)[1] for k in self.knobs] + most)

    def _ends(self, at: int, known: Parameter) -> tuple[float, float]:
        """Return the least and the greatest value of a parameter of an effect, by its index.

        A point of a link lies no farther from its origin than the robot is large: of a farther one
        only the moment would show.
        """
        if known.name in POINT and isinstance(self.effects[at], PointEffect):
            return -self._size, self._size
        effect = self.effects[at]
        if isinstance(effect, ExternalPush) and known.unit == "s":
            # It acts in its middle, or a refit might let it end before it starts.
            middle = 0.5 * (effect.start + effect.end)
            return (known.low, middle) if known.name == "start" else (middle, known.high)
        if effect.kind == "contact" and known.neutral in EDGES:
            # No contact is stiffer than the step allows.
            most = known.high
            if isinstance(effect, ContactSoftness):
                rate = STABLE / self.step
                spec = bare_spec(self.robot, self.step).copy()
                pairs = pairs_of(spec, effect.contact, effect.label)
                mass = min(effective_masses(spec, pairs, effect.label))
                most = mass * (rate**2 if known.name == "stiffness" else rate)
            return known.low, most
        return known.low, known.high

    @cached_property
    def _size(self) -> float:
        """The size of the robot, m."""
        return float(bare_spec(self.robot, self.step).copy().compile().stat.extent)

    def _bounds(self, knob: Knob) -> tuple[float, float]:
        # What an effect says of a link, its own parameter need not say too: the two together
        # would be one number told twice.
        covered = any(knob.part == e.where and knob.kind in e.stands_for for e in self.effects)
        return (0.0, 0.0) if covered else knob.bounds

    @property
    def free_knobs(self) -> int:
        """How many knobs may be turned: those for which no effect stands."""
        own = len(self.knobs)
        return int(np.sum(self.low[:own] < self.high[:own]))

    @cached_property
    def trust(self) -> Array:
        """One over the variance that each entry has before any data, about its nominal."""
        of_knobs = [1.0 / knob.spread**2 for knob in self.knobs]
        # The effects' own bounds are wide: as good as no prior, yet never singular.
        widths = (self.high - self.low)[len(self.knobs) :]
        spreads = [k.spread or width for (_, k), width in zip(self._slots, widths, strict=True)]
        return np.array(of_knobs + [1.0 / spread**2 for spread in spreads])

    @cached_property
    def likely(self) -> Array:
        """What is known beforehand: each entry's likeliest value, NaN where all are alike."""
        of_effects = [
            k.neutral if k.spread and k.neutral is not None else np.nan for _, k in self._slots
        ]
        return np.array([0.0] * len(self.knobs) + of_effects)

    def nudge(self, point: Array) -> Array:
        """Return the step of a finite difference at a point, one for each entry."""
        knobs = np.full(len(self.knobs), 1e-3)
        widths = (self.high - self.low)[len(self.knobs) :]
        # Bounds may lie as good as nowhere: a step is no share of those.
        wide = 0.001 * np.abs(point[len(knobs) :]) + 1e-5 * np.minimum(widths, 1.0)
        # Of what links weigh only sums show: a coarse step would seem to tell them apart.
        rough = [self.effects[i].kind == "contact" for i, _ in self._slots]
        wide = np.where(rough, ROUGH * np.abs(point[len(knobs) :]) + 1e-4, wide)
        fine = np.array([1e-3 * (k.spread or 0.0) for _, k in self._slots])
        step = np.concatenate([knobs, np.where(fine > 0.0, fine, wide)])
        return np.where(point + step > self.high, -step, step)

    def effects_at(self, point: Array) -> tuple[Effect, ...]:
        """Return the effects with their parameters read from a point."""
        values: list[dict[str, float]] = [{} for _ in self.effects]
        inside = np.clip(point, self.low, self.high)[len(self.knobs) :].tolist()
        for (index, known), value in zip(self._slots, inside, strict=True):
            value = float(np.clip(entry(known, value), known.low, known.high))
            # Rounding is no limit: 1 / (1 / 1e9) is less than 1e9.
            unlimited = known.reciprocal and np.isclose(value, known.high, rtol=1e-12)
            values[index][known.name] = known.high if unlimited else value
        return tuple(replace(e, **v) for e, v in zip(self.effects, values, strict=True))  # type: ignore[type-var]

    def spec_at(self, point: Array) -> Any:
        """Return the `mujoco.MjSpec` with the knobs turned, without the effects."""
        return self._turned(spec_of(self.robot, timestep=self.step), point)

    def at(self, point: Array) -> Variant:
        """Return the simulation at a point; it moves as the whole one, and faster."""
        spec = self._turned(bare_spec(self.robot, self.step).copy(), point)
        for name in self.held:
            joint = spec.joint(name)
            # Rates that noise seems to show fade.
            joint.armature, joint.damping = HEAVY, HEAVY / FADES * (np.arange(3) == 0)
        for body in spec.bodies:
            # A centre of mass at a body's origin has a layout of its own, and a fit moves it.
            body.simple = False
        return compiled(spec, self.effects_at(point), self.robot)

    def _turned(self, spec: Any, point: Array) -> Any:
        for knob, value in zip(self.knobs, point, strict=False):
            knob.edit(spec, float(value))
        return spec

    def freed(self) -> Hypothesis:
        """Return the description alone, whose guessed figures of joints may be far less."""
        knobs = tuple(replace(knob, freed=knob.guessed) for knob in self.knobs)
        return replace(self, knobs=knobs, effects=())

    def adding(self, effect: Effect) -> Hypothesis:
        """Return the hypothesis with one more effect, which starts as it stands."""
        return replace(self, effects=(*self.effects, effect))

    def moved_to(self, point: Array) -> Hypothesis:
        """Return the hypothesis whose effects start at a point."""
        return replace(self, effects=self.effects_at(point))


def entry(known: Parameter, value: float) -> float:
    """Return the entry of a point for a parameter's value, and the value for an entry."""
    return 1.0 / value if known.reciprocal else value


def same_kind(one: Effect, other: Effect) -> bool:
    """Return whether two effects are one law at one place."""
    return type(one) is type(other) and one.where == other.where and bool(fields(one))  # type: ignore[arg-type]
