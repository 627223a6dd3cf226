"""A link whose centre of mass is elsewhere than described."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.body.inertial import pull, spatial, steiner
from morph.physics.body.weighed import WeighedEffect
from morph.physics.effect import parameter
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class ComOffset(WeighedEffect):
    """A link's centre of mass lies (x, y, z) from where it is described, in the link's axes.

    Its mass, and its inertia about the centre of mass, stay.

    Source: Atkeson, An and Hollerbach 1986, Int. J. Robotics Research 5(3), eqs. 5 to 8;
    the parallel axis theorem to first order.
    """

    name: ClassVar[str] = "com_offset"
    strengths: ClassVar[tuple[str, ...]] = ("x", "y", "z")
    stands_for: ClassVar[tuple[str, ...]] = ("com",)
    twins: ClassVar[tuple[str, ...]] = (
        "sensor_bias",
        "joint_stiffness",
        "link_inertia",
        "payload",
    )
    excited_by: ClassVar[str] = "Rest in postures where gravity pulls on the link differently."
    separate_by: ClassVar[dict[str, str]] = {
        "sensor_bias": "Rest at three positions far apart: the pull of a weight goes round.",
        "joint_stiffness": "Rest at positions more than a quarter turn apart.",
        "link_inertia": "Motion of a joint further in, with the link held in two postures.",
        "payload": "Motion of a joint further in, with the link held in two postures.",
    }

    body: str
    """Link it acts on."""
    x: float = parameter(0.0, unit="m", low=-0.5, high=0.5, neutral=0.0, spread=0.01)
    """How far along the link's x."""
    y: float = parameter(0.0, unit="m", low=-0.5, high=0.5, neutral=0.0, spread=0.01)
    """How far along the link's y."""
    z: float = parameter(0.0, unit="m", low=-0.5, high=0.5, neutral=0.0, spread=0.01)
    """How far along the link's z."""

    def edit(self, spec: Any) -> None:
        """Move the link's centre of mass."""
        body = spec.body(self.body)
        body.ipos = body.ipos + np.array([self.x, self.y, self.z])

    def regressor(self, motion: Motion) -> Array:
        """Return the force of the link's mass moved by one metre, to first order."""
        body = motion.bodies[self.body]
        return pull(
            body,
            [
                spatial(0.0, body.mass * axis, 2.0 * body.mass * steiner(body.com, axis))
                for axis in np.eye(3)
            ],
        )

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        moved = ", ".join(f"{1e3 * value:.3g}" for value in (self.x, self.y, self.z))
        return (
            f"The centre of mass of link {self.body} lies ({moved}) mm from where it is "
            "described, in the link's axes."
        )
