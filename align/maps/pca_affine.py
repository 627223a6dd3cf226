"""Principal components of both bodies, and an affine map between them through a few pairs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.follow import Following
from morph.alignment.maps.state_law import StateLaw, components, labelled, ridged, unscaled
from morph.alignment.scale import scale


@dataclass(frozen=True, kw_only=True)
class PcaAffine(Following):
    """z_s = A z_t + b between the leading principal components, by ridge through pairs.

    Source: Bocsi, Csato and Peters 2013, IJCNN, section III (both data sets reduced to as many
    dimensions by principal components, then aligned by an affine map in closed form).
    """

    name: ClassVar[str] = "pca_affine"
    needs: ClassVar[frozenset[str]] = frozenset({"pairs"})

    ridge: float = 0.003
    """What a slope of 1 between components costs, as a share of the pairs."""

    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return the affine map through the components."""
        pairs = labelled(given, where=f"map {self.name}")
        ours, theirs = scale(given.source.state), scale(given.target.state)
        count = min(len(ours.spread), len(theirs.spread))
        P = components(ours(given.source.state), count)
        Q = components(theirs(given.target.state), count)
        law, rest = ridged(theirs(pairs.target) @ Q, ours(pairs.source) @ P, self.ridge)
        return unscaled(P @ law @ Q.T, P @ rest, ours, theirs)
