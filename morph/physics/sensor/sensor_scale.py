"""A sensor that reads too much or too little in proportion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.effect import parameter
from morph.physics.kinds import SensorEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class SensorScale(SensorEffect):
    """A channel reads gain times the truth.

    Source: IEEE Std 1293-1998, annex A (scale factor).
    """

    name: ClassVar[str] = "sensor_scale"
    strengths: ClassVar[tuple[str, ...]] = ("gain",)
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("link_inertia", "sensor_bias")
    excited_by: ClassVar[str] = "Motion over the whole range, with a rest at known positions."
    separate_by: ClassVar[dict[str, str]] = {
        "link_inertia": "Rest at two positions that are known otherwise, from stops or marks.",
        "sensor_bias": "Rest at three positions far apart.",
        "timestamp_offset": "Rest at three positions far apart.",
    }

    channel: str
    """Channel it acts on."""
    gain: float = parameter(1.0, unit="-", low=0.01, high=100.0, neutral=1.0)
    """Reading over truth."""

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the position and velocity channels of the hinges and slides."""
        return cls.measured(robot)

    def sense(self, channel: str, reading: Array) -> Array:
        """Return the reading times the gain, on this channel only."""
        return reading * self.gain if channel == self.channel else reading

    def regressor(self, motion: Motion) -> Array:
        """Return no force: only the reading changes."""
        return np.zeros((*motion.velocity.shape, 1))

    def reading_regressor(self, motion: Motion) -> Array:
        """Return the reading itself."""
        reading = motion.reading[:, motion.channels[self.channel]]
        return motion.noticed(self.channel, reading)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Channel {self.channel} reads {100 * self.gain:.4g} % of the truth: a sensor's scale "
            "is off."
        )
