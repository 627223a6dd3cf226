"""A command that acts late."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import ActuatorEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class ActuatorDelay(ActuatorEffect):
    """A command acts T later.

    Source: Franklin, Powell and Workman 1998, Digital Control, section 3.3.
    """

    name: ClassVar[str] = "actuator_delay"
    strengths: ClassVar[tuple[str, ...]] = ("T",)
    twins: ClassVar[tuple[str, ...]] = ("actuator_lag", "timestamp_offset")
    excited_by: ClassVar[str] = "Steps of the command, or commands that change fast."
    separate_by: ClassVar[dict[str, str]] = {
        "actuator_lag": "Single large steps of the command: a delay waits, a lag starts at once.",
    }

    actuator: str
    """Actuator it acts on."""
    T: float = parameter(
        0.0, unit="s", low=0.0, high=0.25, neutral=0.0,
        scan=(0.004, 0.008, 0.014, 0.022, 0.035, 0.055, 0.09),
    )  # fmt: skip
    """Time by which a command acts late."""

    def command(self, actuator: str, command: Array, step: float) -> Array:
        """Return the command later by T; before its start it holds its first value.

        The command is constant over each step. Shifted by a part of a step, its mean
        over a step is the weighted mean of two neighbours, which is exact.
        """
        if actuator != self.actuator or self.T <= 0.0:
            return command
        late = np.maximum(np.arange(command.shape[-1]) - self.T / step, 0.0)
        before = np.floor(late).astype(int)
        after = np.minimum(before + 1, command.shape[-1] - 1)
        part = late - before
        return np.asarray((1.0 - part) * command[..., before] + part * command[..., after])

    def regressor(self, motion: Motion) -> Array:
        """Return what is missing, per second of delay: the mean change of the drive in it."""
        rate = motion.effort_rate(self.actuator)
        if self.T > 0.0:
            total = np.cumsum(np.diff(motion.time, prepend=motion.time[0]) * rate)
            rate = (total - np.interp(motion.time - self.T, motion.time, total)) / self.T
        return motion.actuated(self.actuator, -rate)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return f"Actuator {self.actuator} acts {1e3 * self.T:.3g} ms late: a delay was left out."
