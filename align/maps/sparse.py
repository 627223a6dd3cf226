"""Sparse coding: what the target did, seen as the source's, is made of the source's own atoms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.alignment.arrays import Array
from morph.alignment.errors import SettingError
from morph.alignment.maps.body_map import MapData
from morph.alignment.maps.follow import Following
from morph.alignment.maps.manifold import some
from morph.alignment.maps.state_law import StateLaw, labelled, ridged, unscaled
from morph.alignment.scale import scale
from morph.alignment.states import change

TURNS = 10
"""How often codes and atoms take turns."""


@dataclass(frozen=True, kw_only=True)
class Sparse(Following):
    """Transitions of the source are few atoms each; the map makes the target's transitions so.

    From the map that a few pairs say, rounds of two steps: the target's states and changes, seen
    through the map, are coded by the source's atoms; and the map is fitted anew to what the codes
    make of them, the pairs beside.

    Source: Ammar, Tuyls, Taylor, Driessens and Weiss 2012, AAMAS, sections 4.1 and 4.2 (a
    dictionary of the source's transitions, and the target's coded by it). There the nearest
    codes make pairs and a Gaussian process the map; here the codes' own reconstructions are
    regressed on, and the first map comes from pairs, since codes cannot know a sign.
    """

    name: ClassVar[str] = "sparse"
    needs: ClassVar[frozenset[str]] = frozenset({"pairs"})

    atoms: int = 40
    """How many atoms the dictionary has."""
    active: int = 6
    """How many of them make a transition."""
    rounds: int = 5
    """How often the map is fitted anew."""
    trust: float = 10.0
    """What all pairs together weigh against all transitions together."""
    ridge: float = 0.02
    """What a slope of 1 costs in the first map, as a share of the pairs."""

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        if not (1 <= self.active <= self.atoms <= 200 and self.rounds >= 0 and self.trust > 0.0):
            raise SettingError(
                f"{self.active} of {self.atoms} atoms make a transition, {self.rounds} rounds, "
                f"pairs weigh {self.trust:g}",
                where=f"map {self.name}",
                fix="give 1 to 200 atoms, at least as many as are active, and a positive weight",
            )

    def states(self, given: MapData, rng: np.random.Generator) -> StateLaw:
        """Return the map after the last round."""
        pairs = labelled(given, where=f"map {self.name}")
        ours, theirs = scale(given.source.state), scale(given.target.state)
        some(given.target.state, rng, least=len(theirs.spread) + 2, where=self.name)
        moved = change(given.source.state, given.source.after, given.source.turns) / ours.spread
        moves = moved.std(axis=0) + 1e-9
        whole = np.concatenate([ours(given.source.state), moved / moves], axis=1)
        atoms = dictionary(whole, self.atoms, self.active, rng)
        z, a, b = theirs(given.target.state), ours(pairs.source), theirs(pairs.target)
        step = change(given.target.state, given.target.after, given.target.turns) / theirs.spread
        law, rest = ridged(b, a, self.ridge)
        for _ in range(self.rounds):
            seen = np.concatenate([z @ law.T + rest, step @ law.T / moves], axis=1)
            made = reconstructed(seen, atoms, self.active)
            n = len(moves)
            share = np.sqrt(self.trust * len(z) / len(b))
            rows = np.concatenate([np.column_stack([z, np.ones(len(z))]),
                                   share * np.column_stack([b, np.ones(len(b))])])  # fmt: skip
            price = 1e-3 * len(rows) * np.eye(rows.shape[1])
            normal = rows.T @ rows + price
            for at in range(n):
                # A change of the source's numbers weighs by how large it is there.
                moving = np.column_stack([step / moves[at], np.zeros(len(z))])
                wanted = np.concatenate([made[:, at], share * a[:, at]])
                result = np.linalg.solve(
                    normal + moving.T @ moving,
                    rows.T @ wanted + moving.T @ made[:, n + at] + price @ [*law[at], rest[at]],
                )
                law[at], rest[at] = result[:-1], result[-1]
        return unscaled(law, rest, ours, theirs)


def dictionary(z: Array, atoms: int, active: int, rng: np.random.Generator) -> Array:
    """Return unit atoms of which few at a time make the data, shape (atoms, n).

    Codes by matching pursuit and atoms by least squares take turns; an atom that no datum uses
    begins anew at a datum.

    Source: Engan, Aase and Husoy 1999, ICASSP (method of optimal directions).
    """
    result = _unit(z[rng.integers(len(z), size=atoms)])
    for _ in range(TURNS):
        codes = coded(z, result, active)
        used = np.abs(codes).sum(axis=0) > 0.0
        fresh = z[rng.integers(len(z), size=atoms)]
        result = _unit(np.where(used[:, None], np.linalg.pinv(codes) @ z, fresh))
    return result


def _unit(atoms: Array) -> Array:
    return np.asarray(atoms / np.maximum(np.linalg.norm(atoms, axis=1, keepdims=True), 1e-12))


def coded(z: Array, atoms: Array, active: int) -> Array:
    """Return the codes of data by orthogonal matching pursuit, shape (m, atoms)."""
    codes, left = np.zeros((len(z), len(atoms))), z
    chosen = np.zeros(codes.shape, dtype=bool)
    for count in range(1, active + 1):
        fit = np.where(chosen, -1.0, np.abs(left @ atoms.T))
        np.put_along_axis(chosen, fit.argmax(axis=1)[:, None], True, axis=1)
        which = np.nonzero(chosen)[1].reshape(len(z), count)
        basis = atoms[which]
        gram = basis @ np.swapaxes(basis, 1, 2) + 1e-9 * np.eye(count)
        weight = np.linalg.solve(gram, basis @ z[..., None])[..., 0]
        left = z - np.einsum("mk,mkn->mn", weight, basis)
    np.put_along_axis(codes, which, weight, axis=1)
    return codes


def reconstructed(z: Array, atoms: Array, active: int) -> Array:
    """Return what so many atoms make of data, shape (m, n)."""
    return np.asarray(coded(z, atoms, active) @ atoms)
