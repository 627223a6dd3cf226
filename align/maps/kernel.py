"""A map with a curve of kernels for each number, learned so that transitions are the source's."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from morph.alignment.errors import SettingError
from morph.alignment.maps.body_map import BodyMap, MapData, Mapper
from morph.alignment.maps.feature_warping import flat_curves
from morph.alignment.maps.multistart import Bends, FitBudget, consistent


@dataclass(frozen=True, kw_only=True)
class KernelMapper(Mapper):
    """Each number of the target is straightened by a monotone curve, and an affine map follows.

    For bodies whose numbers are bent one by one: a joint behind a linkage, a sensor that
    saturates, a servo that answers more to large commands. What bends two numbers together asks
    for the network.
    """

    name: ClassVar[str] = "transition_kernel"
    needs: ClassVar[frozenset[str]] = frozenset({"step"})

    cosines: int = 5
    """Parameters of each curve."""
    reach: float = 2.5
    """Kernels stand as far as this on both sides of the mean of a state's number, in spreads."""
    command_reach: float = 1.6
    """The same for a command's; commands by chance have no long tails."""
    hold: float = 1e-4
    """How strongly curves are held straight."""
    effort: FitBudget = field(default_factory=FitBudget)
    """How long it is looked for."""

    def __post_init__(self) -> None:
        """Check the settings."""
        if self.cosines < 1 or min(self.reach, self.command_reach, self.hold) <= 0.0:
            raise SettingError(
                f"cosines is {self.cosines}, reach {self.reach:g}, {self.command_reach:g} and hold "
                f"{self.hold:g}",
                where=f"map {self.name}",
                fix="give one cosine or more, and positive numbers",
            )

    def estimate(self, given: MapData, rng: np.random.Generator) -> BodyMap:
        """Return the curves and the affine map that agree best with the transitions."""
        bends = Bends(
            states=partial(flat_curves, cosines=self.cosines, reach=self.reach),
            commands=partial(flat_curves, cosines=self.cosines, reach=self.command_reach),
            hold=self.hold,
        )
        return consistent(given, rng, effort=self.effort, bends=bends, where=f"map {self.name}")
