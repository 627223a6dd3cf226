"""How much of its speed a body keeps when it bounces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.contact.marks import marked, marks
from morph.physics.contact.pairs import pairs_of
from morph.physics.contact.spring import ratio_of, settle, told
from morph.physics.effect import parameter
from morph.physics.kinds import ContactEffect
from morph.physics.motion import Motion

STEPS = 10.0
"""How many steps an undamped bounce lasts where no stiffness is told."""


@dataclass(frozen=True, kw_only=True)
class Restitution(ContactEffect):
    """Two bodies part after an impact with e times the speed at which they met.

    The contact becomes a spring whose damping ratio makes this e: `spring.restitution_of`,
    which ends at 0.0093; a smaller e is that. The stiffness is that of `contact_softness` where
    it is given; otherwise a bounce lasts ten steps, or more where it is much damped, so at 1 m/s
    and steps of 2 ms it is 6 mm deep. MuJoCo sees an impact within a step, not when it
    begins: single bounces scatter, by 0.03 at e = 0.3 and 0.01 above 0.8.

    Source: Newton 1687, Principia, scholium to the laws; Schwager and Poschel 2007,
    Granular Matter 9, eqs. 16 to 20.
    """

    name: ClassVar[str] = "restitution"
    strengths: ClassVar[tuple[str, ...]] = ()
    twins: ClassVar[tuple[str, ...]] = ("contact_softness",)
    excited_by: ClassVar[str] = "A body that falls freely and bounces at least twice."
    separate_by: ClassVar[dict[str, str]] = {
        "contact_softness": "Time how long the bodies touch: restitution leaves that as it is."
    }

    contact: str
    """The two bodies: `foot+floor`, `any+floor`, `left+right`."""
    e: float = parameter(
        -1.0, unit="-", low=-1.0, high=1.0, neutral=-1.0, scan=(0.1, 0.3, 0.5, 0.7, 0.9)
    )
    """Speed after over speed before; below 0 the contact is as the description has it."""

    def edit(self, spec: Any) -> None:
        """Set the damping of the contact's pairs, and a stiffness where none is told."""
        if self.e < 0.0:
            return
        where, step = f"effect {self.label}", float(spec.option.timestep)
        ratio = ratio_of(self.e)
        for pair in pairs_of(spec, self.contact, where):
            rate = min(math.pi / STEPS, 0.25 / max(ratio, 0.01)) / step
            k = told(pair)[0] if "contact_softness" in marks(pair) else rate**2
            settle(pair, k, 2.0 * ratio * math.sqrt(k), step, where)
            marked(pair, self.name)

    def regressor(self, motion: Motion) -> Array:
        """Return no columns: impacts are too short to lie along a recording."""
        return np.zeros((*motion.velocity.shape, 0))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Contact {self.contact} gives back {self.e:.3g} of the speed of an impact: its "
            "restitution differs from the description's."
        )
