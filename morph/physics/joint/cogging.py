"""A torque that repeats with the position of a joint."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import Simulations, parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion

WAVES = tuple(map(float, (*range(2, 25), *range(26, 51, 2))))
"""Wave numbers to try: teeth of a gear, poles and slots of a motor."""
LEAST = 2.0
"""Least waves in a turn: the least common multiple of poles and slots. One wave is that of gravity,
of buoyancy or of a steady flow."""


@dataclass(frozen=True, kw_only=True)
class Cogging(JointEffect):
    """The magnets draw a joint to where they rest: tau = a sin(n q + phase), in both directions.

    Source: Holtz and Springob 1996, IEEE Trans. Industrial Electronics 43(2), with one
    harmonic of the series; Zhu and Howe 2000, IEEE Trans. Energy Conversion 15(4) (wave numbers).
    """

    name: ClassVar[str] = "cogging"
    strengths: ClassVar[tuple[str, ...]] = ("a", "phase")
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("position_dependent_friction",)
    excited_by: ClassVar[str] = "Slow motion over the whole range in both directions."
    separate_by: ClassVar[dict[str, str]] = {
        "position_dependent_friction": "The same slow path forth and back: friction changes its "
        "sign with the direction, cogging does not.",
        "joint_stiffness": "Rest at many positions close together: cogging repeats.",
        "com_offset": "The same motion with the base turned on its side: gravity's pull turns "
        "along, cogging stays.",
    }

    joint: str
    """Joint it acts on."""
    a: float = parameter(0.0, unit="N m", low=0.0, high=1e4, neutral=0.0)
    """Greatest torque (N on a slide)."""
    n: float = parameter(LEAST, unit="1/rad", low=LEAST, high=1e4, scan=WAVES)
    """Wave number: waves in 2 pi rad (in 2 pi m on a slide)."""
    phase: float = parameter(0.0, unit="-", low=-2.0 * np.pi, high=2.0 * np.pi)
    """Angle of the wave where the joint is at zero, rad also on a slide."""

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Push the joint by what the wave is where it is."""
        wave = self.n * simulations.position(self.joint) + self.phase
        simulations.force(self.joint)[:] += self.a * np.sin(wave)
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return sin(n q) and cos(n q), for a cos(phase) and a sin(phase)."""
        wave = self.n * motion.place(self.joint)
        return motion.along(self.joint, np.sin(wave), np.cos(wave))

    @property
    def coefficients(self) -> Array:
        """The two parts of the wave: a cos(phase) and a sin(phase)."""
        return self.a * np.array([np.cos(self.phase), np.sin(self.phase)])

    def with_strengths(self, coefficients: Array) -> Cogging:
        """Return the wave whose two parts these are."""
        a = float(np.clip(np.hypot(*coefficients), 0.0, 1e4))
        return replace(self, a=a, phase=float(np.arctan2(coefficients[1], coefficients[0])))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, length = ("N", "m") if slide else ("N m", "rad")
        return (
            f"Joint {self.joint} is drawn to and fro by up to {self.a:.3g} {force}, again every "
            f"{2 * np.pi / self.n:.3g} {length}, alike in both directions: cogging was left out."
        )
