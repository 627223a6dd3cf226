"""The fluid that a link sets in motion with it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.errors import EffectError
from morph.physics.effect import parameter
from morph.physics.fluid.numbers import ADDED, POINT, add_numbers, numbers_of
from morph.physics.fluid.wet import AXES, WetEffect, shift
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class AddedMass(WetEffect):
    """The inertia of the fluid that moves along with a link, by Kirchhoff's tensor K.

    With u = [v; w] the velocity of the point (cx, cy, cz) through the fluid, in the link's
    axes, and [p; h] = K u: F = -(dp/dt + w x p), T = -(dh/dt + w x h + v x p).

    Source: Lamb 1932, Hydrodynamics, sections 121 to 124; thesis eq. 7.
    """

    name: ClassVar[str] = "added_mass"
    strengths: ClassVar[tuple[str, ...]] = AXES
    twins: ClassVar[tuple[str, ...]] = ("link_inertia", "payload")
    excited_by: ClassVar[str] = "Fast reversals of the link along each of its axes, in the fluid."
    separate_by: ClassVar[dict[str, str]] = {
        "link_inertia": "The same motion out of the fluid.",
        "payload": "The same motion out of the fluid, or along another axis.",
    }

    body: str
    """Link it acts on."""
    x: float = parameter(0.0, unit="kg", low=0.0, high=1e3, neutral=0.0)
    """Added mass along the link's x."""
    y: float = parameter(0.0, unit="kg", low=0.0, high=1e3, neutral=0.0)
    """Added mass along the link's y."""
    z: float = parameter(0.0, unit="kg", low=0.0, high=1e3, neutral=0.0)
    """Added mass along the link's z."""
    rx: float = parameter(0.0, unit="kg m2", low=0.0, high=1e3, neutral=0.0)
    """Added moment of inertia about the link's x."""
    ry: float = parameter(0.0, unit="kg m2", low=0.0, high=1e3, neutral=0.0)
    """Added moment of inertia about the link's y."""
    rz: float = parameter(0.0, unit="kg m2", low=0.0, high=1e3, neutral=0.0)
    """Added moment of inertia about the link's z."""
    x_y: float = parameter(0.0, unit="kg", low=-1e3, high=1e3, neutral=0.0, free=False)
    x_z: float = parameter(0.0, unit="kg", low=-1e3, high=1e3, neutral=0.0, free=False)
    x_rx: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    x_ry: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    x_rz: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    y_z: float = parameter(0.0, unit="kg", low=-1e3, high=1e3, neutral=0.0, free=False)
    y_rx: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    y_ry: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    y_rz: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    z_rx: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    z_ry: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    z_rz: float = parameter(0.0, unit="kg m", low=-1e3, high=1e3, neutral=0.0, free=False)
    rx_ry: float = parameter(0.0, unit="kg m2", low=-1e3, high=1e3, neutral=0.0, free=False)
    rx_rz: float = parameter(0.0, unit="kg m2", low=-1e3, high=1e3, neutral=0.0, free=False)
    ry_rz: float = parameter(0.0, unit="kg m2", low=-1e3, high=1e3, neutral=0.0, free=False)
    """What couples one axis to another: the upper triangle of K beside its diagonal."""
    cx: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: x."""
    cy: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: y."""
    cz: float = parameter(0.0, unit="m", low=-100.0, high=100.0, spread=0.1)
    """The point that they refer to, in the link's frame: z."""

    def __post_init__(self) -> None:
        """Check the bounds, and that the fluid's energy cannot be negative."""
        super().__post_init__()
        least = float(np.linalg.eigvalsh(_balanced(self.tensor)).min())
        if least < -1e-9:
            raise EffectError(
                f"its tensor has a negative energy along some motion ({least:.3g} of its scale)",
                where=f"effect {self.label}",
                fix="give a tensor that is positive definite, as that of every solid is",
            )

    @classmethod
    def of(cls, body: str, tensor: Array) -> AddedMass:
        """Return the effect of a tensor (6, 6) about the link's origin, in its axes.

        Raises:
            EffectError: The tensor is not symmetric, or would give energy.
        """
        if np.abs(tensor - tensor.T).max() > 1e-6 * np.abs(tensor).max():
            raise EffectError(
                "its tensor is not symmetric",
                where=f"effect {cls.name}@{body}",
                fix="give a symmetric tensor, as that of every solid is",
            )
        entries = {name: float(tensor[at, other]) for name, at, other in ENTRIES}
        return cls(body=body, **entries)

    @property
    def tensor(self) -> Array:
        """K about the point (cx, cy, cz), in the link's axes; kg, kg m, kg m2; shape (6, 6)."""
        whole = np.zeros((6, 6))
        for name, at, other in ENTRIES:
            whole[at, other] = whole[other, at] = getattr(self, name)
        return whole

    def edit(self, spec: Any) -> None:
        """Add to the link's numbers for the fluid, about the point to which its drag refers."""
        moved = shift(self.centre - np.array(numbers_of(spec, self.body)[POINT]))
        whole = moved.T @ self.tensor @ moved
        add_numbers(spec, self.body, ADDED, whole[np.triu_indices(6)].tolist())

    def regressor(self, motion: Motion) -> Array:
        """Return the force of each axis for an added mass of one."""
        body, moved = motion.bodies[self.body], shift(self.centre)
        speed, slope = body.velocity @ moved.T, body.acceleration @ moved.T
        load = np.zeros((len(speed), 6, 6))
        for axis in range(6):
            p, rate = np.zeros((2, len(speed), 6))
            p[:, axis], rate[:, axis] = speed[:, axis], slope[:, axis]
            load[:, :3, axis] = -rate[:, :3] - np.cross(speed[:, 3:], p[:, :3])
            turning = np.cross(speed[:, 3:], p[:, 3:]) + np.cross(speed[:, :3], p[:, :3])
            load[:, 3:, axis] = -rate[:, 3:] - turning
        return body.forces(np.einsum("ji,sjc->sic", moved, load))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Link {self.body} moves {self.x:.3g}, {self.y:.3g} and {self.z:.3g} kg of fluid along "
            "with it: added mass was left out."
        )


ENTRIES: tuple[tuple[str, int, int], ...] = tuple(
    (AXES[i] if i == j else f"{AXES[i]}_{AXES[j]}", i, j) for i in range(6) for j in range(i, 6)
)
"""The name of each entry of the upper triangle of K, row by row, and where it stands."""


def _balanced(tensor: Array) -> Array:
    """Return a tensor scaled to a unit diagonal, so that kg and kg m2 can be compared."""
    size = np.sqrt(np.maximum(np.diag(tensor), 1e-300))
    return np.asarray(tensor / np.outer(size, size))
