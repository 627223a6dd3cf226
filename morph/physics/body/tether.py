"""A cable between a link and a point of the world."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.body.point import PointEffect, points_of
from morph.physics.effect import parameter
from morph.physics.motion import Motion

SHARES = (0.0, 0.5, 0.9)
"""Lengths to try, as shares of the greatest distance along a recording."""


@dataclass(frozen=True, kw_only=True)
class Tether(PointEffect):
    """A cable pulls once it is taut: F = k max(r - length, 0) towards the anchor (x, y, z).

    r is the distance from the anchor, in the world, to the point (cx, cy, cz) of the link's
    frame. The cable has no mass, no damping and no bending.

    Source: Hooke 1678, De potentia restitutiva; as a spring of a spatial tendon with a dead
    band in MuJoCo.
    """

    name: ClassVar[str] = "tether"
    strengths: ClassVar[tuple[str, ...]] = ("k", "x", "y", "z")
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("joint_stiffness", "buoyancy", "payload")
    excited_by: ClassVar[str] = "Rest at places far apart, near the anchor and far from it."
    separate_by: ClassVar[dict[str, str]] = {
        "joint_stiffness": "The same position of the joint with the base at two places.",
        "buoyancy": "Rest at two places of the same depth: a cable's pull changes.",
        "payload": "Rest at two places in the same posture: a cable's pull changes.",
    }

    body: str
    """Link it acts on."""
    k: float = parameter(0.0, unit="N/m", low=0.0, high=1e6, neutral=0.0)
    """Stiffness."""
    length: float = parameter(0.0, unit="m", low=0.0, high=1e4)
    """Length at which it becomes taut."""
    x: float = parameter(0.0, unit="m", low=-1e4, high=1e4)
    """The anchor in the world: x."""
    y: float = parameter(0.0, unit="m", low=-1e4, high=1e4)
    """The anchor in the world: y."""
    z: float = parameter(0.0, unit="m", low=-1e4, high=1e4)
    """The anchor in the world: z."""
    cx: float = parameter(0.0, unit="m", low=-100.0, high=100.0, free=False)
    """Where it is fixed in the link's frame: x."""
    cy: float = parameter(0.0, unit="m", low=-100.0, high=100.0, free=False)
    """Where it is fixed in the link's frame: y."""
    cz: float = parameter(0.0, unit="m", low=-100.0, high=100.0, free=False)
    """Where it is fixed in the link's frame: z."""

    @property
    def _anchor(self) -> Array:
        return np.array([self.x, self.y, self.z])

    def edit(self, spec: Any) -> None:
        """Span a spatial tendon from the anchor to the link."""
        names = f"{self.label}:anchor", f"{self.label}:end"
        spec.worldbody.add_site(name=names[0], pos=self._anchor)
        spec.body(self.body).add_site(name=names[1], pos=self.centre)
        cable = spec.add_tendon(name=self.label, springlength=[0.0, self.length])
        cable.stiffness[0] = self.k
        for name in names:
            cable.wrap_site(name)

    def regressor(self, motion: Motion) -> Array:
        """Return the force for k, k x, k y and k z, at the distances from the anchor as it is."""
        body = motion.bodies[self.body]
        place = self._place(motion)
        distance = np.linalg.norm(place - self._anchor, axis=1)
        taut = np.maximum(1.0 - self.length / np.maximum(distance, 1e-9), 0.0)[:, None, None]
        ones = np.broadcast_to(np.eye(3), (len(place), 3, 3))
        return body.pulled(taut * np.concatenate([-place[:, :, None], ones], axis=2), self.centre)

    def _place(self, motion: Motion) -> Array:
        body = motion.bodies[self.body]
        return np.asarray(body.origin + np.einsum("sij,j->si", body.axes, self.centre))

    @property
    def coefficients(self) -> Array:
        """k, k x, k y and k z."""
        return self.k * np.array([1.0, self.x, self.y, self.z])

    def coefficient_bounds(self) -> tuple[Array, Array]:
        """Return bounds of the first, which is never negative; the others' depend on it."""
        return np.array([0.0, *[-np.inf] * 3]), np.array([1e6, *[np.inf] * 3])

    def with_strengths(self, coefficients: Array) -> Tether:
        """Return the cable whose stiffness and pull these are."""
        k = float(np.clip(coefficients[0], 1e-6, 1e6))
        x, y, z = (float(value) for value in np.clip(coefficients[1:] / k, -1e4, 1e4))
        return replace(self, k=k, x=x, y=y, z=z)

    def shapes(self, motion: Motion) -> tuple[Tether, ...]:
        """Return cables of a few lengths, up to the greatest distance, to a few points."""
        results = []
        for at in points_of(self, motion):
            cable = replace(self, **at)  # type: ignore[arg-type]
            far = float(np.linalg.norm(cable._place(motion) - cable._anchor, axis=1).max())
            results += [replace(cable, length=min(share * far, 1e4)) for share in SHARES]
        return tuple(results)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        place = ", ".join(f"{value:.3g}" for value in (self.x, self.y, self.z))
        return (
            f"Link {self.body} is pulled towards ({place}) m of the world with {self.k:.3g} N for "
            f"each m beyond {self.length:.3g} m: a tether was left out."
        )
