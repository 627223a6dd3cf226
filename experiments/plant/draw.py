"""Which defect goes where: drawn over robots in turn, where it is one by measured fact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.plant.defect import Defect, Planted
from experiments.plant.description import Description


@dataclass(frozen=True, kw_only=True)
class Chosen:
    """A place for one defect."""

    defect: Defect
    """The class."""
    variant: str
    """How it is made."""
    original: Description
    """The description to copy."""
    site: str
    """The link or joint."""
    fact: str
    """The measured fact that makes it a defect there."""


def draw(
    defect: Defect, originals: Sequence[Description], count: int, rng: np.random.Generator
) -> list[Chosen]:
    """Return up to `count` places for a defect, no two the same, from as many robots as there are.

    Variants come in their order. Each goes to the next robot of a drawn order that has a
    place for it, so that no robot gets a second one while another could have its first.
    """
    order = [originals[int(place)] for place in rng.permutation(len(originals))]
    chosen: list[Chosen] = []
    for turn in range(count):
        variant = defect.variants[turn % len(defect.variants)]
        for original in sorted(order, key=lambda one: _had(chosen, one)):
            found = _place(defect, variant, original, chosen, rng)
            if found:
                chosen.append(found)
                break
    return chosen


def _had(chosen: list[Chosen], original: Description) -> int:
    return sum(one.original == original for one in chosen)


def _place(
    defect: Defect,
    variant: str,
    original: Description,
    chosen: list[Chosen],
    rng: np.random.Generator,
) -> Chosen | None:
    """Return a place for a defect in one robot, the first of a drawn order where it matters."""
    taken = {(one.variant, one.site) for one in chosen if one.original == original}
    sites = defect.sites(original, variant)
    for place in rng.permutation(len(sites)):
        site = sites[int(place)]
        if (variant, site) in taken:
            continue
        fact = defect.fact(original, site, variant)
        if fact:
            return Chosen(defect=defect, variant=variant, original=original, site=site, fact=fact)
    return None


def planted(chosen: Chosen, folder: Path, rng: np.random.Generator) -> tuple[Description, Planted]:
    """Return a copy with one defect in it, and what that is."""
    copy = chosen.original.copy_to(folder)
    done = chosen.defect.plant(copy, chosen.site, chosen.variant, rng)
    return copy, Planted(
        defect=chosen.defect.name,
        variant=chosen.variant,
        robot=chosen.original.name,
        site=chosen.site,
        fact=chosen.fact,
        did=done.did,
        places=done.places,
        codes=chosen.defect.codes(chosen.variant),
        also=chosen.defect.also(chosen.variant),
    )
