"""Drag that grows with the square of speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.fluid.drag import Drag
from morph.physics.fluid.numbers import QUADRATIC


@dataclass(frozen=True, kw_only=True)
class QuadraticDrag(Drag):
    """Drag that grows with the square of speed: a bluff link that moves through a fluid.

    F_i = -d_i u_i |u_i| along each axis of the link, and alike about them, where u is the
    velocity through the fluid of the point (cx, cy, cz).

    With a coefficient C and an area A, d = rho C A / 2.

    Source: Morison, O'Brien, Johnson and Schaaf 1950, J. Petroleum Technology 2(5); thesis eq. 7.
    """

    name: ClassVar[str] = "quadratic_drag"
    slot: ClassVar[slice] = QUADRATIC
    twins: ClassVar[tuple[str, ...]] = ("quadratic_damping", "linear_drag")
    excited_by: ClassVar[str] = (
        "Fast motion of the link beside slow motion, along each of its axes."
    )
    separate_by: ClassVar[dict[str, str]] = {
        "quadratic_damping": "The same motion out of the fluid."
    }

    body: str
    """Link it acts on."""
    x: float = parameter(0.0, unit="N s2/m2", low=0.0, high=1e3, neutral=0.0)
    """Drag along the link's x."""
    y: float = parameter(0.0, unit="N s2/m2", low=0.0, high=1e3, neutral=0.0)
    """Drag along the link's y."""
    z: float = parameter(0.0, unit="N s2/m2", low=0.0, high=1e3, neutral=0.0)
    """Drag along the link's z."""
    rx: float = parameter(0.0, unit="N m s2/rad2", low=0.0, high=1e3, neutral=0.0)
    """Drag about the link's x."""
    ry: float = parameter(0.0, unit="N m s2/rad2", low=0.0, high=1e3, neutral=0.0)
    """Drag about the link's y."""
    rz: float = parameter(0.0, unit="N m s2/rad2", low=0.0, high=1e3, neutral=0.0)
    """Drag about the link's z."""
    cx: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: x."""
    cy: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: y."""
    cz: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: z."""

    @staticmethod
    def law(speed: Array) -> Array:
        """Return its square, with its sign."""
        return speed * abs(speed)
