"""A channel whose clock is off."""

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
class TimestampOffset(SensorEffect):
    """What a channel says of time t was read at t - T: its stamps are late by T.

    Source: Furgale, Rehder and Siegwart 2013, IEEE/RSJ IROS (temporal offset).
    """

    name: ClassVar[str] = "timestamp_offset"
    strengths: ClassVar[tuple[str, ...]] = ("T",)
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("actuator_delay", "actuator_lag")
    excited_by: ClassVar[str] = "Fast motion that several channels see."
    separate_by: ClassVar[dict[str, str]] = {
        "actuator_delay": "Push the link by hand: a channel's clock shows against the other "
        "channels, a late command does not.",
        "actuator_lag": "Push the link by hand: a channel's clock shows against the other "
        "channels, a lag of the motor does not.",
    }

    channel: str
    """Channel it acts on."""
    T: float = parameter(0.0, unit="s", low=-1.0, high=1.0, neutral=0.0)
    """Time by which its stamps are late; below 0 early."""

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the position and velocity channels of the hinges and slides."""
        return cls.measured(robot)

    def stamp(self, channel: str, time: Array) -> Array:
        """Return the times later by T, on this channel only."""
        return time + self.T if channel == self.channel else time

    def regressor(self, motion: Motion) -> Array:
        """Return no force: only the reading changes."""
        return np.zeros((*motion.velocity.shape, 1))

    def reading_regressor(self, motion: Motion) -> Array:
        """Return minus how fast the reading changes, in the mean over the offset."""
        rate, time = motion.reading_rate[:, motion.channels[self.channel]], motion.time
        if self.T != 0.0:
            # The rate between two samples, and beyond the ends, changes at one pace.
            step, read = np.diff(time), time - self.T
            total = np.cumsum(np.r_[0.0, 0.5 * step * (rate[1:] + rate[:-1])])
            before = np.clip(np.searchsorted(time, read, side="right") - 1, 0, len(step) - 1)
            since, pace = read - time[before], (np.diff(rate) / step)[before]
            at = total[before] + since * (rate[before] + 0.5 * pace * since)
            rate = (total - at) / self.T
        return motion.noticed(self.channel, -rate)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        late = "late" if self.T > 0.0 else "early"
        return (
            f"Channel {self.channel} is stamped {1e3 * abs(self.T):.3g} ms too {late} against the "
            "others: the offset of a clock was left out."
        )
