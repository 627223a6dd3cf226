"""The lift of the fluid that a link displaces."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import EffectError
from morph.physics.effect import parameter
from morph.physics.fluid.numbers import CENTRE, DISPLACED, numbers_of, write_numbers
from morph.physics.fluid.wet import WetEffect, shift
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class Buoyancy(WetEffect):
    """A link is lifted by the weight of the fluid that it displaces: F = -rho V g.

    It acts at the centre of buoyancy (cx, cy, cz).

    Source: Archimedes; Lamb 1932, Hydrodynamics, section 2; thesis eq. 7, F_b.
    """

    name: ClassVar[str] = "buoyancy"
    strengths: ClassVar[tuple[str, ...]] = ("volume",)
    twins: ClassVar[tuple[str, ...]] = ("payload",)
    excited_by: ClassVar[str] = "Rest at several attitudes in the fluid."
    separate_by: ClassVar[dict[str, str]] = {
        "payload": "Rest beside fast motion: a payload has inertia, a lift has none.",
    }

    body: str
    """Link it acts on."""
    volume: float = parameter(0.0, unit="m3", low=0.0, high=10.0, neutral=0.0)
    """Volume of fluid that the link displaces."""
    density: float = parameter(1000.0, unit="kg/m3", low=0.01, high=2e4, free=False)
    """Density of the fluid: 1000 for fresh water, 1025 for the sea, 1.2 for air."""
    cx: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """Centre of buoyancy in the link's frame: x."""
    cy: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """Centre of buoyancy in the link's frame: y."""
    cz: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """Centre of buoyancy in the link's frame: z."""

    def edit(self, spec: Any) -> None:
        """Write the displaced mass and its centre into the link's numbers for the fluid."""
        numbers = numbers_of(spec, self.body)
        if numbers[DISPLACED.start] != 0.0:
            raise EffectError(
                f"{self.body} is lifted by buoyancy already",
                where=f"effect {self.label}",
                fix="give each link one buoyancy",
            )
        numbers[DISPLACED] = [self.volume * self.density]
        numbers[CENTRE] = self.centre.tolist()
        write_numbers(spec, self.body, numbers)

    def regressor(self, motion: Motion) -> Array:
        """Return the force of one cubic metre."""
        body = motion.bodies[self.body]
        lift = np.zeros((len(body.gravity), 6))
        lift[:, :3] = -self.density * body.gravity
        return body.forces((lift @ shift(self.centre))[:, :, None])

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Link {self.body} displaces {1e3 * self.volume:.3g} litres of a fluid of "
            f"{self.density:.4g} kg/m3: buoyancy was left out."
        )
