"""A command that is followed gradually."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import ActuatorEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class ActuatorLag(ActuatorEffect):
    """A command is followed with a first-order lag: T dx/dt = u - x.

    Source: Franklin, Powell and Emami-Naeini 2019, Feedback Control, section 3.3.
    """

    name: ClassVar[str] = "actuator_lag"
    strengths: ClassVar[tuple[str, ...]] = ("T",)
    twins: ClassVar[tuple[str, ...]] = ("actuator_delay", "series_elasticity")
    excited_by: ClassVar[str] = "Steps of the command, or commands that change fast."
    separate_by: ClassVar[dict[str, str]] = {
        "actuator_delay": "Single large steps of the command: a delay waits, a lag starts at once.",
    }

    actuator: str
    """Actuator it acts on."""
    T: float = parameter(
        0.0, unit="s", low=0.0, high=0.5, neutral=0.0,
        scan=(0.004, 0.01, 0.02, 0.04, 0.08, 0.15),
    )  # fmt: skip
    """Time constant."""

    def command(self, actuator: str, command: Array, step: float) -> Array:
        """Return the lagged command, its mean over each step; it starts settled.

        Exact for a command that is constant over each step of length h: with
        a = exp(-h/T) the lagged value moves from x to u + (x - u) a, and its mean
        on the way is u + (x - u) (1 - a) T / h.
        """
        if actuator != self.actuator or self.T < 1e-6:
            return command
        from scipy.signal import lfilter

        decay = float(np.exp(-step / self.T))
        first = command[..., :1]
        after, _ = lfilter([1.0 - decay], [1.0, -decay], command, zi=first * decay)
        before = np.concatenate([first, after[..., :-1]], axis=-1)
        return np.asarray(command + (before - command) * (1.0 - decay) * self.T / step)

    def regressor(self, motion: Motion) -> Array:
        """Return what is missing, per second of lag: the faded change of the drive so far."""
        rate = motion.effort_rate(self.actuator)
        if self.T > 0.0:
            from scipy.signal import lfilter

            decay = float(np.exp(-np.median(np.diff(motion.time)) / self.T))
            rate = lfilter([1.0 - decay], [1.0, -decay], rate)
        return motion.actuated(self.actuator, -rate)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Actuator {self.actuator} follows its command with a lag of {1e3 * self.T:.3g} ms: "
            "the motor's own dynamics were left out."
        )
