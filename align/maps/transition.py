"""An affine map, learned so that the target's transitions are the source's."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.bent_map import BentMap
from morph.alignment.maps.body_map import MapData, Mapper
from morph.alignment.maps.multistart import FitBudget, consistent


@dataclass(frozen=True, kw_only=True)
class TransitionMapper(Mapper):
    """x = S y + s and u = R a + r with S y' + s = f(S y + s, R a + r), f the source's simulator.

    Actions fix what shapes of clouds of states cannot: signs, and which joint is which.
    """

    name: ClassVar[str] = "transition"
    needs: ClassVar[frozenset[str]] = frozenset({"step"})

    effort: FitBudget = field(default_factory=FitBudget)
    """How long it is looked for."""

    def estimate(self, given: MapData, rng: np.random.Generator) -> AffineMap:
        """Return the affine map that agrees best with the transitions."""
        where = f"map {self.name}"
        return straightened(consistent(given, rng, effort=self.effort, bends=None, where=where))


def straightened(bent: BentMap) -> AffineMap:
    """Return the affine map that a map without bends is, in the target's own units."""
    affine = bent.affine
    by_state, by_command = 1.0 / bent.spread, 1.0 / bent.command_spread
    back, command = bent.spread[:, None], bent.command_spread[:, None]
    away, told_away = by_state * bent.middle, by_command * bent.command_middle
    action_shift = affine.action_shift - affine.action_state @ away
    read_shift = affine.read_shift - affine.read_law @ told_away - affine.read_state @ away
    return AffineMap(
        state_law=affine.state_law * by_state,
        state_shift=affine.state_shift - affine.state_law @ away,
        lift_law=back * affine.lift_law,
        lift_shift=bent.middle + bent.spread * affine.lift_shift,
        action_law=command * affine.action_law,
        action_state=command * affine.action_state * by_state,
        action_shift=bent.command_middle + bent.command_spread * action_shift,
        read_law=affine.read_law * by_command,
        read_state=affine.read_state * by_state,
        read_shift=read_shift,
    )
