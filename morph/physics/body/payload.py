"""A weight on a link that the description does not know."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.vary.pseudo import pseudo_inertia, set_pseudo_inertia
from morph.physics.body.inertial import pull, spatial, steiner
from morph.physics.body.weighed import WeighedEffect
from morph.physics.effect import parameter
from morph.physics.motion import Motion

PLACES = (1.0, 2.0, 3.0)
"""Distances to try from the link's origin, as shares of that of its centre of mass."""


@dataclass(frozen=True, kw_only=True)
class Payload(WeighedEffect):
    """A link carries m at the point (x, y, z) of its frame.

    Source: Atkeson, An and Hollerbach 1986, Int. J. Robotics Research 5(3), section 4.
    """

    name: ClassVar[str] = "payload"
    strengths: ClassVar[tuple[str, ...]] = ("m", "x", "y", "z")
    twins: ClassVar[tuple[str, ...]] = ("torque_scale", "link_inertia", "com_offset")
    excited_by: ClassVar[str] = "Rest in postures where gravity pulls differently, fast reversals."
    separate_by: ClassVar[dict[str, str]] = {
        "torque_scale": "Rest under constant commands in several postures: a weight pulls alike "
        "at every command.",
        "link_inertia": "Fast turning about the centre of mass: a payload at one point moves it.",
        "com_offset": "Motion of a joint further in, with the link held in two postures.",
        "buoyancy": "Rest beside fast motion: a payload has inertia, a lift has none.",
        "added_mass": "The same motion out of the fluid, or along another axis.",
    }

    body: str
    """Link it acts on."""
    m: float = parameter(0.0, unit="kg", low=0.0, high=1e4, neutral=0.0)
    """Mass of the weight."""
    x: float = parameter(0.0, unit="m", low=-2.0, high=2.0)
    """Where it is in the link's frame: x."""
    y: float = parameter(0.0, unit="m", low=-2.0, high=2.0)
    """Where it is in the link's frame: y."""
    z: float = parameter(0.0, unit="m", low=-2.0, high=2.0)
    """Where it is in the link's frame: z."""

    def edit(self, spec: Any) -> None:
        """Join a point of mass m to the link."""
        if self.m > 0.0:
            body, point = spec.body(self.body), np.array([self.x, self.y, self.z, 1.0])
            set_pseudo_inertia(body, pseudo_inertia(body) + self.m * np.outer(point, point))

    def regressor(self, motion: Motion) -> Array:
        """Return the force for m, m x, m y and m z: exact for a weight where it is.

        With c that place, or the centre of mass where none is told, r r' = c r' + r c' - c c' +
        (r - c)(r - c)', and the last is left out.
        """
        body, given = motion.bodies[self.body], np.array([self.x, self.y, self.z])
        near = given if given.any() else body.com
        columns = [spatial(1.0, np.zeros(3), -steiner(near, near))]
        columns += [spatial(0.0, axis, 2.0 * steiner(near, axis)) for axis in np.eye(3)]
        return pull(body, columns)

    def shapes(self, motion: Motion) -> tuple[Payload, ...]:
        """Return weights near the link's middle, its end and beyond."""
        com = motion.bodies[self.body].com
        places = [np.clip(share * com, -2.0, 2.0).tolist() for share in PLACES]
        return tuple(replace(self, x=x, y=y, z=z) for x, y, z in places)

    @property
    def coefficients(self) -> Array:
        """m, m x, m y and m z."""
        return self.m * np.array([1.0, self.x, self.y, self.z])

    def coefficient_bounds(self) -> tuple[Array, Array]:
        """Return bounds of the first, which is never negative; the others' depend on it."""
        return np.array([0.0, *[-np.inf] * 3]), np.array([1e4, *[np.inf] * 3])

    def with_strengths(self, coefficients: Array) -> Payload:
        """Return the weight whose mass and first moment these are."""
        m = float(np.clip(coefficients[0], 1e-6, 1e4))
        x, y, z = (float(value) for value in np.clip(coefficients[1:] / m, -2.0, 2.0))
        return replace(self, m=m, x=x, y=y, z=z)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        place = ", ".join(f"{1e3 * value:.3g}" for value in (self.x, self.y, self.z))
        load = f"{self.m:.3g} kg" if self.m > 0.9995 else f"{1e3 * self.m:.3g} g"
        return (
            f"Link {self.body} carries {load} more, at ({place}) mm of its frame: "
            "a payload was left out."
        )
