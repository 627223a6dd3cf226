"""Dry friction that fades as a joint speeds up."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import Simulations, parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion

MOST = 1e4
"""Greatest level of friction, N m."""


@dataclass(frozen=True, kw_only=True)
class StribeckFriction(JointEffect):
    """Dry friction that is greatest at rest and fades as a joint speeds up.

    tau = -(c + (s - c) exp(-(v/vs)^2)) sign(v), and holds at rest up to s. Friction that is
    greater in motion is no Stribeck friction: with s below c it is that of Coulomb, of level c.

    Source: Armstrong-Helouvry, Dupont and Canudas de Wit 1994, Automatica 30(7), eq. 3.
    """

    name: ClassVar[str] = "stribeck_friction"
    strengths: ClassVar[tuple[str, ...]] = ("c", "s")
    dissipative: ClassVar[bool] = True
    holds: ClassVar[bool] = True
    simpler: ClassVar[str] = "coulomb_friction"
    twins: ClassVar[tuple[str, ...]] = ("coulomb_friction", "backlash")
    excited_by: ClassVar[str] = (
        "Very slow motion in both directions, faster motion, and starts from rest."
    )
    separate_by: ClassVar[dict[str, str]] = {
        "coulomb_friction": "Very slow motion in both directions, then a start from rest under a "
        "slowly growing command.",
    }

    joint: str
    """Joint it acts on."""
    c: float = parameter(0.0, unit="N m", low=0.0, high=MOST, neutral=0.0)
    """Friction of the joint in fast motion (N on a slide)."""
    s: float = parameter(0.0, unit="N m", low=0.0, high=MOST, neutral=0.0)
    """Friction of the joint at rest, at least `c` (N on a slide)."""
    vs: float = parameter(0.2, unit="rad/s", low=0.01, high=5.0, scan=(0.05, 0.15, 0.5, 1.5))
    """Speed at which what `s` adds to `c` has fallen to 1/e (m/s on a slide)."""

    def level(self, velocity: Array) -> Array:
        """Return the greatest friction, N m, at each velocity, rad/s; shape (...,)."""
        return np.asarray(self.c + self._fades() * np.exp(-((velocity / self.vs) ** 2)))

    def _fades(self) -> Array:
        """Return by how much friction at rest is greater."""
        return np.maximum(np.asarray(self.s) - self.c, 0.0)

    def edit(self, spec: Any) -> None:
        """Add the friction at rest to the joint's friction loss."""
        spec.joint(self.joint).frictionloss += self.c + float(self._fades())

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Give back, along the motion, what friction has faded by at this speed."""
        # The friction constraint holds up to s; what is missing at speed vanishes
        # smoothly at rest, so that an ordinary force can supply it.
        velocity = simulations.velocity(self.joint)
        faded = self.c + self._fades() - self.level(velocity)
        simulations.force(self.joint)[:] += faded * np.sign(velocity)
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return the friction at every speed, and what fades of it."""
        sign = motion.sign(self.joint)
        fading = np.exp(-((motion.speed(self.joint) / self.vs) ** 2))
        return motion.along(self.joint, -sign, -sign * fading)

    @property
    def coefficients(self) -> Array:
        """What its columns are multiplied by: `c`, and by how much `s` is greater."""
        return np.array([self.c, float(self._fades())])

    def coefficient_bounds(self) -> tuple[Array, Array]:
        """Return the least and greatest of its coefficients: neither is negative."""
        return np.zeros(2), np.full(2, MOST)

    def with_strengths(self, coefficients: Array) -> StribeckFriction:
        """Return the effect with both levels read off a linear fit, none negative."""
        c, fades = np.clip(coefficients, 0.0, MOST)
        return replace(self, c=float(c), s=float(min(c + fades, MOST)))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, speed = ("N", "m/s") if slide else ("N m", "rad/s")
        return (
            f"Joint {self.joint} sticks up to {self.s:.3g} {force} at rest and loses {self.c:.3g} "
            f"{force} when it moves faster than about {self.vs:.2g} {speed}: Stribeck friction was "
            "left out."
        )
