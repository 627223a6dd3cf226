"""Windows of a long recording, one of which is shown at a time."""

from __future__ import annotations

import itertools

import numpy as np

WINDOW = 20.0
"""Seconds of a long recording that are shown at one time."""
SPARE = 0.25
"""A last window shorter than this part of one is joined to the one before."""


def windows(seconds: float) -> tuple[tuple[float, float], ...]:
    """Return from and to of each window of a recording, s; together they are all of it."""
    count = max(1, int(np.ceil(seconds / WINDOW - SPARE)))
    edges = [WINDOW * number for number in range(count)] + [seconds]
    return tuple(itertools.pairwise(edges))
