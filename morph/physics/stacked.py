"""One effect for many simulations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from morph.physics.effect import Some


def stacked(effects: Sequence[Some]) -> Some:
    """Return one effect whose parameters are arrays, one entry a simulation.

    The bounds were checked when each was made; the dataclass is filled as it is.
    """
    first = effects[0]
    whole = object.__new__(type(first))
    numbers = {p.name for p in first.parameters()}
    for item in fields(first):  # type: ignore[arg-type]
        values = [getattr(effect, item.name) for effect in effects]
        value = np.array(values, dtype=float) if item.name in numbers else values[0]
        object.__setattr__(whole, item.name, value)
    return whole
