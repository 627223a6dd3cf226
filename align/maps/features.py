"""Task features: states are alike that look alike to the task, whatever the bodies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import MapError
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.follow import Following
from morph.alignment.maps.state_law import StateLaw


@dataclass(frozen=True, kw_only=True)
class Features(Following):
    """C_s x = C_t y: x = pinv(C_s) C_t y, the least x that the task cannot tell from y.

    The two matrices come from descriptions, not from data; without them it refuses.
    """

    name: ClassVar[str] = "features"

    source_look: Array = field(default_factory=lambda: np.zeros((0, 0)))
    """C_s, what the task looks at on the source, shape (k, n_s)."""
    target_look: Array = field(default_factory=lambda: np.zeros((0, 0)))
    """C_t, the same on the target, shape (k, n_t)."""

    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return the map that the looks say."""
        wanted = (given.source.state.shape[1], given.target.state.shape[1])
        results = (self.source_look.shape[1], self.target_look.shape[1])
        if wanted != results or len(self.source_look) != len(self.target_look):
            raise MapError(
                f"the looks have the shapes {self.source_look.shape} and {self.target_look.shape}",
                where=f"map {self.name}",
                fix=f"give as many rows of both, {wanted[0]} columns of one and {wanted[1]} of "
                "the other: the bodies must share a quantity that the task looks at",
            )
        S = np.linalg.pinv(self.source_look) @ self.target_look
        return StateLaw(S=S, s=np.zeros(wanted[0]))
