"""Dry friction where two bodies touch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.contact.pairs import pairs_of
from morph.physics.effect import parameter
from morph.physics.kinds import ContactEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class ContactFriction(ContactEffect):
    """Two bodies that touch resist sliding with up to mu times what presses them together.

    |f_t| <= mu f_n, against the sliding velocity where they slide. Twisting about the
    normal is resisted with up to torsional f_n, rolling with up to rolling f_n, in full only
    above a speed of turning of (1 - d) / (d b) mu^2 g / torsional: with MuJoCo's own d = 0.9 and
    b = 105 / s, and mu = 1, 5 rad/s for 2 mm.

    Giving mu makes friction a cone, in every contact of the world, as the law has it;
    MuJoCo's own pyramid of four faces, quicker and up to 1 - 1/sqrt(2) weaker along its
    diagonals, is had with `pyramid=1`. MuJoCo knows one shape for all contacts: the last of
    several effects decides.

    Source: Coulomb 1785, as in Stewart 2000, SIAM Review 42(1), eq. 2; MuJoCo
    documentation, Computation, Friction cones.
    """

    name: ClassVar[str] = "contact_friction"
    strengths: ClassVar[tuple[str, ...]] = ()
    twins: ClassVar[tuple[str, ...]] = ("contact_softness",)
    excited_by: ClassVar[str] = "Sliding to a stop, or standing on a slope until it slips."
    separate_by: ClassVar[dict[str, str]] = {
        "contact_softness": "Slide a body without letting it drop: how far it goes is friction's."
    }

    contact: str
    """The two bodies: `foot+floor`, `any+floor`, `left+right`."""
    mu: float = parameter(
        -1.0, unit="-", low=-1.0, high=5.0, neutral=-1.0, scan=(0.1, 0.2, 0.4, 0.8)
    )
    """Sliding friction coefficient; below 0 it is as the description has it."""
    torsional: float = parameter(0.0, unit="m", low=0.0, high=0.1, neutral=0.0, free=False)
    """Twisting friction over pressing force; 0 for none beyond the description's."""
    rolling: float = parameter(0.0, unit="m", low=0.0, high=0.1, neutral=0.0, free=False)
    """Rolling friction over pressing force; 0 for none beyond the description's."""
    pyramid: float = parameter(0.0, unit="-", low=0.0, high=1.0, neutral=0.0, free=False)
    """1 for MuJoCo's pyramid of four faces instead of the cone."""

    def edit(self, spec: Any) -> None:
        """Set the friction of the contact's pairs, and the shape of friction."""
        if self == self.neutral():
            return
        for pair in pairs_of(spec, self.contact, f"effect {self.label}"):
            friction = list(pair.friction)
            # Of a contact without friction the description leaves one dimension.
            pair.condim = max(pair.condim, 3)
            if self.mu >= 0.0:
                friction[:2] = self.mu, self.mu
            if self.torsional > 0.0:
                friction[2], pair.condim = self.torsional, max(pair.condim, 4)
            if self.rolling > 0.0:
                friction[3:], pair.condim = [self.rolling] * 2, 6
            pair.friction = friction
        if self.pyramid > 0.5:
            spec.option.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL
        elif self.mu >= 0.0:
            spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC

    def regressor(self, motion: Motion) -> Array:
        """Return no columns: the pressing force is not in a recording of motion."""
        return np.zeros((*motion.velocity.shape, 0))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Contact {self.contact} slides with a friction coefficient of {self.mu:.3g}: its "
            "friction differs from the description's."
        )
