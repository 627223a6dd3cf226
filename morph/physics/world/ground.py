"""Ground to stand on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.contact.floor import NOWHERE, floor_of
from morph.physics.effect import parameter
from morph.physics.kinds import WorldEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class Ground(WorldEffect):
    """A level floor without end: the half space below a height pushes back.

    0 <= f, 0 <= gap, f gap = 0 at every point that touches it.

    Source: Signorini 1933, as in Stewart 2000, SIAM Review 42(1), eq. 1.
    """

    name: ClassVar[str] = "ground"
    strengths: ClassVar[tuple[str, ...]] = ()
    twins: ClassVar[tuple[str, ...]] = ("end_stop", "external_push")
    excited_by: ClassVar[str] = "A part of the body that comes down, stops, and stays."
    separate_by: ClassVar[dict[str, str]] = {
        "end_stop": "Come down in two poses: a floor stops at a height, a joint at an angle.",
        "external_push": "Come down twice: a floor is there every time.",
    }

    height: float = parameter(0.0, unit="m", low=NOWHERE, high=1000.0, neutral=NOWHERE)
    """Height of the floor; at its least value nothing touches it."""

    def edit(self, spec: Any) -> None:
        """Put the world's floor at the height."""
        floor = floor_of(spec, f"effect {self.label}")
        if self.height > NOWHERE:
            floor.pos = (*floor.pos[:2], self.height)

    def regressor(self, motion: Motion) -> Array:
        """Return no columns: what a floor pushes is not linear in its height."""
        return np.zeros((*motion.velocity.shape, 0))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return f"The world has a floor at a height of {self.height:.3g} m: the ground was left out."
