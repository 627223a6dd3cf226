"""A contact that gives way as a spring and a damper."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.contact.marks import marked, marks
from morph.physics.contact.pairs import pairs_of
from morph.physics.contact.spring import effective_masses, settle, told
from morph.physics.effect import parameter
from morph.physics.kinds import ContactEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class ContactSoftness(ContactEffect):
    """Two bodies that touch give way: f = stiffness r + damping dr/dt, never a pull.

    Both act on the body as a whole, shared among the points in which it touches, and are
    exact for the effective mass of `spring.effective_masses`: a free body's own mass, for a
    link of a robot what MuJoCo's inverse weight at the described pose says. Against an impact
    the contact is this spring and damper; of a lasting load F it bears a share d = 0.5 without
    giving way, so at rest it is (1 - d) F / stiffness deep, half of what the spring would be,
    and less where it touches in several points. What friction holds creeps at most at
    (1 - d) / d times its pull over the damping: 5 mm/s for 1 N and 200 N s/m.

    Source: Kelvin and Voigt's model, as in Johnson 1985, Contact Mechanics, section 6.5;
    MuJoCo documentation, Modeling, Solver parameters, eq. solref_direct.
    """

    name: ClassVar[str] = "contact_softness"
    strengths: ClassVar[tuple[str, ...]] = ()
    twins: ClassVar[tuple[str, ...]] = ("restitution",)
    excited_by: ClassVar[str] = "Impacts sampled several times while they last."
    separate_by: ClassVar[dict[str, str]] = {
        "restitution": "Time how long the bodies touch: softness sets that, restitution does not."
    }

    contact: str
    """The two bodies: `foot+floor`, `any+floor`, `left+right`."""
    stiffness: float = parameter(
        0.0, unit="N/m", low=0.0, high=1e7, neutral=0.0, scan=(3e2, 3e3, 3e4)
    )
    """Force per depth; 0 leaves the contact as the description has it."""
    damping: float = parameter(-1.0, unit="N s/m", low=-1.0, high=1e5, neutral=-1.0)
    """Force per speed; below 0 critical, 2 sqrt(stiffness mass), or as near as the step allows.
    Where `restitution` is told, that decides instead."""

    def edit(self, spec: Any) -> None:
        """Set the stiffness and damping of the contact's pairs."""
        if self.stiffness <= 0.0:
            return
        where = f"effect {self.label}"
        pairs = pairs_of(spec, self.contact, where)
        for pair, mass in zip(pairs, effective_masses(spec, pairs, where), strict=True):
            k = self.stiffness / mass
            # Just inside what `settle` takes, so that a default never asks for a shorter step.
            most = 0.999 / spec.option.timestep
            b = self.damping / mass if self.damping >= 0.0 else min(2.0 * math.sqrt(k), most)
            if "restitution" in marks(pair):
                before, damping = told(pair)
                b = damping * math.sqrt(k / before)
            settle(pair, k, b, spec.option.timestep, where)
            marked(pair, self.name)

    def regressor(self, motion: Motion) -> Array:
        """Return no columns: depths of contacts are not in a recording of motion."""
        return np.zeros((*motion.velocity.shape, 0))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        damped = f"{self.damping:.3g} N s/m" if self.damping >= 0.0 else "critical damping"
        return (
            f"Contact {self.contact} gives way with {self.stiffness:.3g} N/m and {damped}: its "
            "softness differs from the description's."
        )
