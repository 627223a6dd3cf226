"""Floors by name: a few numbers each, where they come from, and how sure they are.

The numbers are handbook values and choices, good for a first simulation and no better: friction
of one pair of materials differs by a third between samples, softness with the foot. What a
recording holds is found by fitting `contact_friction`, `contact_softness` and `restitution`.
"""

from __future__ import annotations

from dataclasses import dataclass

from morph.errors import EffectError
from morph.physics.contact.contact_friction import ContactFriction
from morph.physics.contact.contact_softness import ContactSoftness
from morph.physics.contact.restitution import Restitution
from morph.physics.effect import Effect
from morph.physics.world.ground import Ground

EVERYWHERE = "any+floor"


@dataclass(frozen=True, kw_only=True)
class Surface:
    """What a foot meets on one kind of floor."""

    name: str
    """What it is called."""
    mu: float
    """Sliding friction coefficient."""
    mu_source: str
    """Where that comes from."""
    e: float
    """Restitution."""
    e_source: str
    """Where that comes from."""
    stiffness: float
    """N/m under one foot; 0 for as stiff as the step of the simulation allows."""
    stiffness_source: str
    """Where that comes from."""


SURFACES = (
    Surface(
        name="hard_floor",
        mu=0.6,
        mu_source="Wood or hard plastic on smooth concrete: 0.62 in common engineering tables "
        "(quoted from memory), rounded down.",
        e=0.5,
        e_source="Chosen: between hard balls on stone (0.8 to 0.9) and a body of many parts.",
        stiffness=0.0,
        stiffness_source="Concrete gives less than any step of milliseconds can follow.",
    ),
    Surface(
        name="rubber_on_wood",
        mu=0.8,
        mu_source="Rubber on dry wood: 0.7 to 0.95 in common engineering tables (quoted from "
        "memory), the middle.",
        e=0.4,
        e_source="Chosen: balls of soft rubber reach 0.7 to 0.8, pads under a body much less.",
        stiffness=5e3,
        stiffness_source="E A / t of a pad: 2 MPa (rubber of 40 Shore A, Gent 1958, Rubber "
        "Chemistry and Technology 31, from memory), 0.5 cm2, 20 mm.",
    ),
    Surface(
        name="pla_on_carpet",
        mu=0.4,
        mu_source="Assumed: hard plastics on textiles are reported from 0.2 to 0.5 and depend on "
        "the pile; no source for printed PLA was found.",
        e=0.1,
        e_source="Chosen: a pile swallows an impact.",
        stiffness=625.0,
        stiffness_source="E A / t of a pile: 50 kPa (assumed), 1 cm2, 8 mm.",
    ),
)
"""Every floor that has a name."""


def surface(name: str, *, height: float = 0.0) -> tuple[Effect, ...]:
    """Return the effects that make a floor of a named kind: ground, and how it is to touch.

    A light foot on a stiff floor needs a short step: `contact_softness` says which.

    Args:
        name: One of `SURFACES`.
        height: Of the floor, m.

    Raises:
        EffectError: There is no such floor.
    """
    for known in SURFACES:
        if known.name == name:
            effects = (
                Ground(height=height),
                ContactFriction(contact=EVERYWHERE, mu=known.mu),
                ContactSoftness(contact=EVERYWHERE, stiffness=known.stiffness),
                Restitution(contact=EVERYWHERE, e=known.e),
            )
            return tuple(effect for effect in effects if effect != effect.neutral())
    raise EffectError(
        f"there is no floor {name!r}; there are {', '.join(s.name for s in SURFACES)}",
        where="morph.physics.contact.presets.surface",
        fix="name one of these, or give the effects themselves",
    )
