"""A map with a small network that has an inverse, learned so that transitions are the source's."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

import numpy as np

from morph.alignment.errors import SettingError
from morph.alignment.maps.body_map import BodyMap, MapData, Mapper
from morph.alignment.maps.feature_warping import idle_network
from morph.alignment.maps.multistart import Bends, FitBudget, consistent


@dataclass(frozen=True, kw_only=True)
class NetworkMapper(Mapper):
    """A residual network of one hidden layer straightens the target, and an affine map follows.

    Its branch's Lipschitz constant stays below 1, so that it has an inverse. Numbers may be bent
    together, as where one joint's reading depends on another's; for numbers bent one by one the
    curves of `transition_kernel` need fewer transitions.
    """

    name: ClassVar[str] = "transition_network"
    needs: ClassVar[frozenset[str]] = frozenset({"step"})

    hidden: int = 16
    """Width of the hidden layer, for states; a half of it for commands."""
    hold: float = 1e-4
    """How strongly weights are held to 0."""
    effort: FitBudget = field(default_factory=FitBudget)
    """How long it is looked for."""

    def __post_init__(self) -> None:
        """Check the settings."""
        if self.hidden < 2 or self.hold <= 0.0:
            raise SettingError(
                f"hidden is {self.hidden} and hold {self.hold:g}",
                where=f"map {self.name}",
                fix="give two or more, and a positive number",
            )

    def estimate(self, given: MapData, rng: np.random.Generator) -> BodyMap:
        """Return the network and the affine map that agree best with the transitions."""
        bends = Bends(
            states=partial(idle_network, hidden=self.hidden, rng=rng),
            commands=partial(idle_network, hidden=self.hidden // 2, rng=rng),
            hold=self.hold,
        )
        return consistent(given, rng, effort=self.effort, bends=bends, where=f"map {self.name}")
