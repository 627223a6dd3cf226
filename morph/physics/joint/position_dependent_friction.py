"""Dry friction that comes and goes with the position of a joint."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import Simulations, parameter
from morph.physics.joint.cogging import WAVES
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class PositionDependentFriction(JointEffect):
    """Dry friction changes with position: abs(tau) <= max(c + a sin(n q + phase), 0).

    One harmonic stands for a periodic level; a level that is tabulated is a sum of them.
    It is read before each step, and holds at rest.

    Source: Popovic and Goldenberg 1998, IEEE Trans. Robotics and Automation 14(1), with
    one harmonic; set-valued form as in Stewart 2000, SIAM Review 42(1), eq. 2.
    """

    name: ClassVar[str] = "position_dependent_friction"
    strengths: ClassVar[tuple[str, ...]] = ("c", "a", "phase")
    dissipative: ClassVar[bool] = True
    holds: ClassVar[bool] = True
    suspected: ClassVar[bool] = False
    simpler: ClassVar[str] = "coulomb_friction"
    twins: ClassVar[tuple[str, ...]] = ("cogging", "coulomb_friction")
    excited_by: ClassVar[str] = "Slow motion over the whole range in both directions."
    separate_by: ClassVar[dict[str, str]] = {
        "cogging": "The same slow path forth and back: friction changes its sign with the "
        "direction, cogging does not.",
        "coulomb_friction": "Slow motion over the whole range in both directions.",
    }

    joint: str
    """Joint it acts on."""
    c: float = parameter(0.0, unit="N m", low=0.0, high=1e4, neutral=0.0)
    """Mean level (N on a slide)."""
    a: float = parameter(0.0, unit="N m", low=0.0, high=1e4, neutral=0.0)
    """By how much the level rises and falls about the mean (N on a slide)."""
    n: float = parameter(1.0, unit="1/rad", low=0.01, high=1e4, scan=WAVES)
    """Wave number: waves in 2 pi rad (in 2 pi m on a slide)."""
    phase: float = parameter(0.0, unit="-", low=-2.0 * np.pi, high=2.0 * np.pi)
    """Angle of the wave where the joint is at zero, rad also on a slide."""

    def level(self, position: Array) -> Array:
        """Return the greatest friction, N m, at each position, rad; shape (...,)."""
        return np.asarray(np.maximum(self.c + self.a * np.sin(self.n * position + self.phase), 0.0))

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Let the joint hold and lose what it does where it is."""
        simulations.friction(self.joint)[:] += self.level(simulations.position(self.joint))
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return minus the sense of motion, alone and times sin(n q) and cos(n q)."""
        place = motion.place(self.joint)
        # Where the wave is cut off at zero nothing acts.
        uncut = self.c + self.a * np.sin(self.n * place + self.phase) >= 0.0
        sign, wave = -motion.sign(self.joint) * uncut, self.n * place
        return motion.along(self.joint, sign, sign * np.sin(wave), sign * np.cos(wave))

    @property
    def coefficients(self) -> Array:
        """c, a cos(phase) and a sin(phase)."""
        return np.array([self.c, self.a * np.cos(self.phase), self.a * np.sin(self.phase)])

    def with_strengths(self, coefficients: Array) -> PositionDependentFriction:
        """Return the friction whose mean and wave these are, the wave no larger than the mean."""
        c = float(np.clip(coefficients[0], 0.0, 1e4))
        a = float(min(np.hypot(*coefficients[1:]), c))
        return replace(self, c=c, a=a, phase=float(np.arctan2(coefficients[2], coefficients[1])))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, length = ("N", "m") if slide else ("N m", "rad")
        return (
            f"Joint {self.joint} loses {self.c:.3g} {force} against its motion, more or less by "
            f"{self.a:.3g} {force} every {2 * np.pi / self.n:.3g} {length}: friction that changes "
            "with position was left out."
        )
