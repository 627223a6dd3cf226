"""A base that stands askew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import WorldEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class BaseTilt(WorldEffect):
    """Gravity comes from elsewhere: the world's axes lean by roll about x, then pitch about y.

    Seen in them gravity is R' g, with R the turn about y times that about x; to first order
    (pitch, -roll, 0) times 9.81 m/s2. It is the turn of `ground_slope`: on a robot that is
    bolted to such a slope gravity pulls so. A fluid's surface leans along, its lift too; the
    regressor leaves that lift out.

    Source: Craig 2005, Introduction to Robotics, eq. 2.64, with no turn about z.
    """

    name: ClassVar[str] = "base_tilt"
    strengths: ClassVar[tuple[str, ...]] = ("roll", "pitch")
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("sensor_bias", "com_offset", "ground_slope")
    excited_by: ClassVar[str] = "Rest at positions where gravity pulls differently."
    separate_by: ClassVar[dict[str, str]] = {
        "sensor_bias": "The same rest after the base was turned about the vertical.",
        "com_offset": "The same rest after the base was turned about the vertical.",
        "ground_slope": "Let a part hang free above the ground: gravity's direction shows there.",
    }

    roll: float = parameter(0.0, unit="rad", low=-1.2, high=1.2, neutral=0.0)
    """Turn about the world's x axis; positive lets gravity pull towards -y."""
    pitch: float = parameter(0.0, unit="rad", low=-1.2, high=1.2, neutral=0.0)
    """Turn about the world's y axis; positive lets gravity pull towards +x."""

    def edit(self, spec: Any) -> None:
        """Turn the description's gravity."""
        if self.roll or self.pitch:
            cr, sr = np.cos(self.roll), np.sin(self.roll)
            cp, sp = np.cos(self.pitch), np.sin(self.pitch)
            about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
            about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
            spec.option.gravity = (about_y @ about_x).T @ spec.option.gravity

    def regressor(self, motion: Motion) -> Array:
        """Return what gravity does once turned by one rad, of all links that the motion knows."""
        whole = np.zeros((*motion.velocity.shape, 2))
        for body in motion.bodies.values():
            gravity = np.einsum("sij,sj->si", body.axes, body.gravity)
            # A small turn of the axes by w turns what is seen in them by -w: g x w.
            turns = np.stack([np.cross(gravity, axis) for axis in np.eye(3)[:2]], axis=2)
            whole += body.pulled(body.mass * turns, body.com)
        return whole

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"The base leans in the world by {self.roll:.3g} rad about x and {self.pitch:.3g} rad "
            "about y: gravity comes from elsewhere than described."
        )
