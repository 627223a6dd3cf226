"""A sensor that reads too much or too little by a constant."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import SensorEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class SensorBias(SensorEffect):
    """A channel reads the truth plus a constant.

    Source: IEEE Std 1293-1998, annex A (bias).
    """

    name: ClassVar[str] = "sensor_bias"
    strengths: ClassVar[tuple[str, ...]] = ("bias",)
    twins: ClassVar[tuple[str, ...]] = ("base_tilt", "com_offset")
    excited_by: ClassVar[str] = "Rest at positions where gravity pulls differently."
    separate_by: ClassVar[dict[str, str]] = {
        "joint_stiffness": "Rest at three positions far apart.",
    }

    channel: str
    """Channel it acts on."""
    bias: float = parameter(0.0, unit="rad", low=-3.2, high=3.2, neutral=0.0)
    """Reading minus truth (m on a slide)."""

    def sense(self, channel: str, reading: Array) -> Array:
        """Return the reading plus the constant, on this channel only."""
        return reading + self.bias if channel == self.channel else reading

    def regressor(self, motion: Motion) -> Array:
        """Return the change of force that a shifted position needs."""
        joint = self.channel.rsplit(".", 1)[0]
        return motion.stiffness[:, :, motion.joints[joint]][:, :, None]

    def reading_regressor(self, motion: Motion) -> Array:
        """Return one."""
        return motion.noticed(self.channel, np.ones(len(motion.reading)))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        more = "much" if self.bias > 0.0 else "little"
        return (
            f"Channel {self.channel} reads {abs(self.bias):.3g} {'m' if slide else 'rad'} too "
            f"{more}: a sensor's zero is off."
        )
