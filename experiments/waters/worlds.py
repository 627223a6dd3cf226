"""The swimmer's six worlds, and what no model of them knows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.swim.water import DENSITY, aqua_water
from morph.body.load import load
from morph.body.robot import Robot
from morph.physics.effect import Effect
from morph.physics.fluid.added_mass import AddedMass
from morph.physics.fluid.buoyancy import Buoyancy
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.fluid.quadratic_drag import QuadraticDrag
from morph.physics.fluid.thrust import Thrust
from morph.physics.fluid.wet import AXES
from morph.sim.simulator import Simulator

STEP = 0.01
"""Seconds a step. Truths and models step alike, so a shorter one would change no answer."""

FRESH, BRACKISH, SALT = DENSITY, 1012.0, 1025.0
"""Densities, kg/m3."""


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """What a world does that no model of it knows."""

    current: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Velocity of the fluid, m/s."""
    hull_drag: float = 1.0
    """Factor on the hull's drag."""
    paddle_drag: float = 1.0
    """Factor on the paddles' drag."""
    thrust: float = 1.0
    """Factor on the paddles' thrust."""


@dataclass(frozen=True, kw_only=True)
class World:
    """A body in a fluid."""

    name: str
    """How the study calls it."""
    body: str
    """Its body on the shelf, which decides mass and ballast."""
    density: float = FRESH
    """Of the fluid, kg/m3."""
    hull_drag: float = 1.0
    """Factor on the hull's drag: what grows on a hull roughens it."""

    def simulator(self, unknown: Disturbance | None = None) -> Simulator:
        """Return it as a simulation, perhaps disturbed."""
        effects = self._effects(unknown or Disturbance())
        return Simulator(load(self.body), effects, step=STEP, integrator="implicitfast")

    def _effects(self, unknown: Disturbance) -> tuple[Effect, ...]:
        fresh: Robot = load("hexapod_swimmer")
        thicker = self.density / DENSITY
        found: list[Effect] = []
        for effect in aqua_water(fresh, thrust=unknown.thrust):
            if isinstance(effect, AddedMass):
                effect = replace(effect, **{axis: thicker * getattr(effect, axis) for axis in AXES})
            elif isinstance(effect, QuadraticDrag):
                hull = effect.body == "hull"
                factor = self.hull_drag * unknown.hull_drag if hull else unknown.paddle_drag
                drag = {axis: thicker * factor * getattr(effect, axis) for axis in AXES}
                effect = replace(effect, **drag)
            elif isinstance(effect, Buoyancy | Thrust):
                effect = replace(effect, density=self.density)
            found.append(effect)
        x, y, z = unknown.current
        return (*found, FluidCurrent(x=x, y=y, z=z))


WORLDS = (
    World(name="fresh", body="hexapod_swimmer"),
    World(name="fresh, ballast forward", body="hexapod_swimmer_ballast"),
    World(name="fresh, hull overgrown", body="hexapod_swimmer", hull_drag=2.0),
    World(name="brackish", body="hexapod_swimmer", density=BRACKISH),
    World(name="salt", body="hexapod_swimmer", density=SALT),
    World(name="salt, trimmed for it", body="hexapod_swimmer_salt", density=SALT),
)
"""The ensemble."""


DOUBTS = (
    Disturbance(hull_drag=1.15),
    Disturbance(paddle_drag=1.15),
    Disturbance(thrust=1.075),
    Disturbance(current=(0.02, 0.0, 0.0)),
    Disturbance(current=(0.0, 0.02, 0.0)),
    Disturbance(current=(0.0, 0.0, 0.02)),
)
"""Figures that an engineer would doubt, each moved by a standard deviation: drags and thrust, then
the current."""

COEFFICIENTS = 3
"""How many of them are coefficients."""


def halfway(one: World, other: World) -> World:
    """Return the world between two that share a body."""
    return replace(
        one,
        name=f"between {one.name} and {other.name}",
        density=0.5 * (one.density + other.density),
        hull_drag=float(np.sqrt(one.hull_drag * other.hull_drag)),
    )
