"""Alignment by local geometry with a few landmarks, so that the target tracks the source."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.follow import Following
from morph.alignment.maps.manifold import aligned, check_graph
from morph.alignment.maps.state_law import StateLaw


@dataclass(frozen=True, kw_only=True)
class Uma(Following):
    """Local geometry says what corresponds, landmarks what geometry cannot know: the signs.

    The target's first policy tracks what the source would do (`follow.py`); policy gradients, or
    whatever search there is, go on from there. Without pairs it is the unsupervised method of the
    source.

    Source: Ammar, Eaton, Ruvolo and Taylor 2015, AAAI, algorithm 1.
    """

    name: ClassVar[str] = "uma"

    nearest: int = 8
    """How many neighbours a state has."""
    weight: float = 30.0
    """What all landmarks together weigh against all neighbours of both bodies together."""
    geometry: float = 0.1
    """What alikeness of local geometry weighs against them where there are landmarks."""

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        check_graph(self.nearest, min(self.weight, self.geometry), where=f"map {self.name}")

    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return the law by which both embeddings are one."""
        paired = given.pairs is not None
        return aligned(
            given,
            rng,
            nearest=self.nearest,
            weight=self.weight if paired else 0.0,
            free=self.geometry if paired else 1.0,
            where=self.name,
        )
