"""A current that is looked for together with the drag through which it acts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.physics.effect import Effect, parameter
from morph.physics.fluid.drag import Drag
from morph.physics.fluid.fluid_current import FluidCurrent
from morph.physics.motion import Motion

ALONG = slice(0, 3)
"""Of a drag's strengths those along a link's axes."""
FASTEST = 3.0
"""Most speed of a current to begin with, m/s."""


@dataclass(frozen=True, kw_only=True)
class Streaming(FluidCurrent):
    """A current through one drag that is not found yet: a column of their product alone.

    Without its current a drag explains little of what both do, and without a drag a current
    explains nothing. The drag is taken to be the same along all axes of its link.
    """

    drag: Drag
    """The drag, at a shape of its grid."""
    x: float = parameter(0.0, unit="-", low=-1e9, high=1e9, neutral=0.0)
    """Velocity along the world's x times the drag's mean strength along axes."""
    y: float = parameter(0.0, unit="-", low=-1e9, high=1e9, neutral=0.0)
    """The same along y."""
    z: float = parameter(0.0, unit="-", low=-1e9, high=1e9, neutral=0.0)
    """The same along z."""

    def regressor(self, motion: Motion) -> Array:
        """Return the force through a drag of one along each axis, shape (samples, dofs, 3)."""
        strengths = np.zeros(len(self.drag.strengths))
        strengths[ALONG] = 1.0
        return self.through([self.drag.with_strengths(strengths)], motion)


def streams(grids: Sequence[tuple[Effect, ...]]) -> list[tuple[Effect, ...]]:
    """Return a current through each drag at each of its shapes, a grid of one each."""
    drags = [shape for grid in grids for shape in grid if isinstance(shape, Drag)]
    return [(Streaming(drag=drag),) for drag in drags]


def resolved(effects: Sequence[Effect]) -> tuple[Effect, ...]:
    """Return effects with currents in the place of their products with a drag."""
    drags = {effect.label: effect for effect in effects}
    return tuple(
        _current(each, drags[each.drag.label]) if isinstance(each, Streaming) else each
        for each in effects
    )


def acting_together(effects: Sequence[Effect], at: int) -> list[int]:
    """Return the indices of an effect and of what has no effect, or another one, without it.

    They are a current and the only drag through which it acts; else the effect alone.

    Args:
        effects: A set.
        at: Index of the effect.
    """
    drags = [number for number, each in enumerate(effects) if isinstance(each, Drag)]
    currents = [number for number, each in enumerate(effects) if isinstance(each, FluidCurrent)]
    pair = [*drags, *currents]
    return sorted(pair) if len(drags) == len(currents) == 1 and at in pair else [at]


def _current(product: Streaming, drag: Effect) -> FluidCurrent:
    strength = max(float(np.mean(drag.coefficients[ALONG])), 1e-12)
    speeds = product.coefficients / strength
    most = float(np.abs(speeds).max(initial=0.0))
    x, y, z = (speeds * min(1.0, FASTEST / max(most, 1e-12))).tolist()
    return FluidCurrent(x=x, y=y, z=z)
