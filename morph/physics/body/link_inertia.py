"""A link that is heavier or lighter, or harder or easier to turn, than described."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.body.inertial import pull, spatial, steiner
from morph.physics.body.weighed import WeighedEffect
from morph.physics.effect import parameter
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class LinkInertia(WeighedEffect):
    """A link has `mass` times its mass, and `inertia` times its inertia about its centre of mass.

    Its centre of mass stays. A part of another density has both factors alike; one that is
    printed as walls around an infill has not.

    Source: Atkeson, An and Hollerbach 1986, Int. J. Robotics Research 5(3), eqs. 5 to 8.
    """

    name: ClassVar[str] = "link_inertia"
    strengths: ClassVar[tuple[str, ...]] = ("mass", "inertia")
    stands_for: ClassVar[tuple[str, ...]] = ("mass", "inertia")
    twins: ClassVar[tuple[str, ...]] = ("torque_scale", "armature", "com_offset", "payload")
    excited_by: ClassVar[str] = "Rest in postures where gravity pulls differently, fast reversals."
    separate_by: ClassVar[dict[str, str]] = {
        "torque_scale": "The same motion with the joint driven from outside, or a known weight "
        "hung on the link.",
        "armature": "Rest in postures far apart: a rotor has no weight.",
        "com_offset": "Motion of a joint further in, with the link held in two postures.",
        "payload": "Fast turning about the centre of mass: a payload at one point moves it.",
        "added_mass": "The same motion out of the fluid.",
    }

    body: str
    """Link it acts on."""
    mass: float = parameter(1.0, unit="-", low=0.02, high=20.0, neutral=1.0, spread=0.5)
    """True mass over the described."""
    inertia: float = parameter(1.0, unit="-", low=0.02, high=20.0, neutral=1.0, spread=0.5)
    """True moments of inertia about the centre of mass over the described."""

    def edit(self, spec: Any) -> None:
        """Scale the link's mass and its inertia."""
        body = spec.body(self.body)
        body.mass *= self.mass
        body.inertia = body.inertia * self.inertia
        body.fullinertia = body.fullinertia * self.inertia

    def regressor(self, motion: Motion) -> Array:
        """Return the force of all of the mass at its centre, and of all of the inertia about it."""
        body = motion.bodies[self.body]
        point = spatial(body.mass, body.mass * body.com, body.mass * steiner(body.com, body.com))
        return pull(body, [point, spatial(0.0, np.zeros(3), body.inertia)])

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Link {self.body} has {100 * self.mass:.3g} % of the mass described, and about its "
            f"centre {100 * self.inertia:.3g} % of the inertia."
        )
