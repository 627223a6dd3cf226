"""The maps of a chain, read from beside its record."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from morph.alignment.errors import AlignError
from morph.alignment.maps.body_map import BodyMap
from morph.alignment.maps.files import read
from morph.app.viewer.align.chain_bodies import ChainPlayer
from morph.app.viewer.align.transfer_record import Story
from morph.errors import ViewError
from morph.policy_transfer.body import Body


def maps_of(story: Story, players: Sequence[ChainPlayer]) -> tuple[BodyMap | None, ...]:
    """Return the map of each hop; None where there is none, or it is between other bodies.

    Raises:
        ViewError: A map is spoilt.
    """
    return tuple(
        None if hop.map is None else _fitting(_read(hop.map), here.body, there.body)
        for hop, (here, there) in zip(story.hops, pairwise(players), strict=True)
    )


def _read(path: Path) -> BodyMap:
    try:
        # A pipe would be waited for.
        if not path.is_file():
            raise ViewError("it is no file", where=str(path), fix="give the folder as it was")
        return read(path)
    except AlignError as error:
        raise ViewError(error.what, where=error.where, fix=error.fix) from error


def _fitting(body_map: BodyMap, source: Body | None, target: Body | None) -> BodyMap | None:
    if source is None or target is None:
        return None
    try:
        there = body_map.state(np.zeros((1, target.size)))
        back = body_map.state_back(np.zeros((1, source.size)))
    # Of numbers for other bodies numpy complains in its own ways.
    except Exception:
        return None
    return body_map if (there.shape[1], back.shape[1]) == (source.size, target.size) else None
