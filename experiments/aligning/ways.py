"""Everything that may say how a target is seen as a source: the family, and its controls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array, Mask
from morph.alignment.errors import AlignError
from morph.alignment.maps.affine_map import AffineMap
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.features import Features
from morph.alignment.maps.follow import Following, linear
from morph.alignment.maps.manifold import Manifold, ManifoldFree
from morph.alignment.maps.pca_affine import PcaAffine
from morph.alignment.maps.sparse import Sparse
from morph.alignment.maps.state_law import StateLaw, labelled, ridged, unscaled
from morph.alignment.maps.transport import Transport
from morph.alignment.maps.uma import Uma
from morph.alignment.pairs import shuffled
from morph.alignment.samples import Pairs
from morph.alignment.scale import scale
from morph.alignment.states import change
from morph.arrays import JSON

FAMILY: tuple[Following, ...] = (Manifold(), Uma(), Sparse(), PcaAffine(), Transport())
"""What learns from landmarks; each is shown beside itself with the landmarks shuffled."""

GOAL = ("manifold", "uma", "sparse")
"""Wang and Mahadevan, unsupervised alignment with landmarks, sparse coding."""

RIDGE = "pairs_only"
"""The rival: ridge regression on the same landmarks, without any manifold."""

Score = Callable[[AffineMap], float]
"""What a map is worth: the score of the source's policy seen through it."""


@dataclass(frozen=True, kw_only=True)
class PairsOnly(Following):
    """Ridge regression on the landmarks alone: what is gained without any manifold."""

    name: ClassVar[str] = RIDGE

    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return the regression; the transitions give no more than the scales."""
        pairs = labelled(given, where="pairs only")
        ours, theirs = scale(given.source.state), scale(given.target.state)
        law, rest = ridged(theirs(pairs.target), ours(pairs.source), 0.02)
        return unscaled(law, rest, ours, theirs)


def flipped(pairs: Pairs, numbers: Mask) -> Pairs:
    """Return landmarks of which some numbers of the source have the wrong sign."""
    return Pairs(source=np.where(numbers, -1.0, 1.0) * pairs.source, target=pairs.target)


def shown_by(
    given: MapData, looks: tuple[Array, Array], law: Array, score: Score, seed: int
) -> dict[str, JSON]:
    """Return score and agreement of every way, by its name.

    The agreement is the median, over the numbers of the source, of 1 - |x - x'|^2 / |x'|^2, x'
    being what the task features say; a map that is refused has a score of 0 and none.

    Args:
        given: What maps are learned from, with pairs.
        looks: What the task looks at on the source and on the target.
        law: The true law of states, x = law y.
        score: What a map is worth.
        seed: Of all chance here.
    """
    told: dict[str, tuple[Following, MapData]] = {}
    if given.pairs is not None:
        wrong = shuffled(given.pairs, np.random.default_rng([seed, 1]))
        # A place and its rate turned, the tilt not: the sign that geometry cannot know.
        half = np.arange(len(law)) % (len(law) // 2) == 0
        turned = flipped(given.pairs, half)
        for each in (*FAMILY, PairsOnly()):
            told[each.name] = (each, given)
            told[f"{each.name}, shuffled"] = (each, replace(given, pairs=wrong))
        told["manifold, sign flipped"] = (Manifold(), replace(given, pairs=turned))
    bare = replace(given, pairs=None)
    told["manifold_free"] = (ManifoldFree(), bare)
    told["uma, no landmark"] = (Uma(), bare)
    told["transport, no landmark"] = (Transport(), bare)
    told["features"] = (Features(source_look=looks[0], target_look=looks[1]), bare)
    return {name: _measured(each, what, law, score, seed) for name, (each, what) in told.items()}


def _measured(mapper: Following, given: MapData, law: Array, score: Score, seed: int) -> JSON:
    try:
        found = mapper.estimate(given, np.random.default_rng([seed, 2]))
    except AlignError as error:
        return {"score": 0.0, "agreement": 0.0, "refused": str(error).split("\n")[0]}
    truth = given.target.state @ law.T
    off = found.state(given.target.state) - truth
    share = 1.0 - np.square(off).sum(axis=0) / np.square(truth).sum(axis=0)
    return {"score": score(found), "agreement": max(float(np.median(share)), -1.0)}


def measures(given: MapData) -> dict[str, float]:
    """Return what may foretell, without a label, whether two bodies share a manifold.

    `dimension`: by how much the participation ratios (sum l)^2 / sum l^2 of the spectra of
    scaled states differ. `spectrum`: how far apart the sorted shares of variance are. `growth`:
    how far apart the four largest growths of the linear models are, in logarithms. `bent`: the
    share of the target's variance that a linear model leaves beside that of noise. `thin`: the
    least spectral share of the target's leading directions, as many as the source has numbers,
    in logarithms.
    """
    ours, theirs = (scale(each.state)(each.state) for each in (given.source, given.target))
    spectra = [np.linalg.svd(z, compute_uv=False) ** 2 / z.size for z in (ours, theirs)]
    ratios = [float(s.sum() ** 2 / np.square(s).sum()) for s in spectra]
    n = min(len(spectra[0]), len(spectra[1]))
    shares = [s[:n] / s.sum() for s in spectra]
    growths = []
    left = []
    for each in (given.source, given.target):
        model = linear(each)
        growths.append(np.sort(np.abs(np.linalg.eigvals(model.A)))[::-1][:4])
        told = each.state @ model.A.T + each.command @ model.B.T + model.c
        moved = change(each.state, each.after, each.turns)
        off = np.square(each.after - told).sum(axis=0) / np.maximum(
            np.square(moved).sum(axis=0), 1e-12
        )
        left.append(float(np.median(off)))
    k = min(len(growths[0]), len(growths[1]))
    logs = [np.log(np.maximum(g[:k], 1e-6)) for g in growths]
    return {
        "dimension": abs(ratios[1] - ratios[0]),
        "spectrum": float(np.abs(shares[1] - shares[0]).sum()),
        "growth": float(np.abs(logs[1] - logs[0]).max()),
        "bent": left[1],
        "thin": -float(np.log10(max(float(shares[1][n - 1]), 1e-12))),
    }
