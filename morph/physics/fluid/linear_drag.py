"""Drag that grows with speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.fluid.drag import Drag
from morph.physics.fluid.numbers import LINEAR


@dataclass(frozen=True, kw_only=True)
class LinearDrag(Drag):
    """Drag that grows with speed: a link that creeps through a fluid.

    F_i = -d_i u_i along each axis of the link, and alike about them, where u is the
    velocity through the fluid of the point (cx, cy, cz).

    Source: Lamb 1932, Hydrodynamics, section 337 (Stokes); Fossen 2011, eq. 6.58.
    """

    name: ClassVar[str] = "linear_drag"
    slot: ClassVar[slice] = LINEAR
    twins: ClassVar[tuple[str, ...]] = ("viscous_friction", "quadratic_drag")
    excited_by: ClassVar[str] = (
        "Motion of the link at two speeds far apart, along each of its axes."
    )
    separate_by: ClassVar[dict[str, str]] = {
        "viscous_friction": "The same motion out of the fluid."
    }

    body: str
    """Link it acts on."""
    x: float = parameter(0.0, unit="N s/m", low=0.0, high=1e3, neutral=0.0)
    """Drag along the link's x."""
    y: float = parameter(0.0, unit="N s/m", low=0.0, high=1e3, neutral=0.0)
    """Drag along the link's y."""
    z: float = parameter(0.0, unit="N s/m", low=0.0, high=1e3, neutral=0.0)
    """Drag along the link's z."""
    rx: float = parameter(0.0, unit="N m s/rad", low=0.0, high=1e3, neutral=0.0)
    """Drag about the link's x."""
    ry: float = parameter(0.0, unit="N m s/rad", low=0.0, high=1e3, neutral=0.0)
    """Drag about the link's y."""
    rz: float = parameter(0.0, unit="N m s/rad", low=0.0, high=1e3, neutral=0.0)
    """Drag about the link's z."""
    cx: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: x."""
    cy: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: y."""
    cz: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: z."""

    @staticmethod
    def law(speed: Array) -> Array:
        """Return the speed."""
        return speed
