"""An actuator that weakens as it gets hot."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import UNLIMITED, Simulations, parameter
from morph.physics.kinds import ActuatorEffect
from morph.physics.motion import Motion

RATES = (1.0, 3.0, 10.0)
"""Rates to try, in heatings during a recording; slower ones differ by a factor alone."""


@dataclass(frozen=True, kw_only=True)
class ThermalDerating(ActuatorEffect):
    """Gain falls with heat: tau = (1 - (1 - floor) x) u, dx/dt = rate (u / level)^2 (1 - x).

    u is what the actuator would produce cold, and x its heat, 0 at the start of a run and 1 once
    it is hot. It does not cool within a run.

    Source: Joule 1841, Philosophical Magazine 19: heat with the square of the current, to
    which torque is in proportion; one lumped winding without losses to the housing.
    """

    name: ClassVar[str] = "thermal_derating"
    strengths: ClassVar[tuple[str, ...]] = ("floor",)
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("voltage_sag", "torque_scale")
    excited_by: ClassVar[str] = "A long run under load, with the same motion at start and end."
    separate_by: ClassVar[dict[str, str]] = {
        "voltage_sag": "The same motion at the start and at the end of a long run: sag depends on "
        "the load of the moment.",
        "torque_scale": "The same motion at the start and at the end of a long run.",
    }

    actuator: str
    """Actuator it acts on."""
    floor: float = parameter(1.0, unit="-", low=0.0, high=1.0, neutral=1.0)
    """Gain of the hot actuator."""
    rate: float = parameter(0.1, unit="1/s", low=0.0, high=1e3)
    """How fast it heats up at its working level: one over the time to get hot."""
    level: float = parameter(1.0, unit="N m", low=1e-6, high=UNLIMITED, free=False)
    """Working level of its torque (N on a slide)."""

    def initial_state(self, simulations: Simulations) -> Any:
        """Return no heat."""
        return np.zeros_like(simulations.control(self.actuator))

    def recalled(self, motion: Motion) -> Array:
        """Return the heat along the recording."""
        effort = motion.effort(self.actuator)
        heats = self.rate * (effort[:-1] / self.level) ** 2 * np.diff(motion.time)
        return np.asarray(-np.expm1(-np.cumsum(np.concatenate([[0.0], heats]))))

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Weaken the actuator, and heat it up."""
        effort = simulations.effort(self.actuator)
        heat = simulations.step * self.rate * (effort / self.level) ** 2
        effort[:] *= 1.0 - (1.0 - self.floor) * state
        return state - np.expm1(-heat) * (1.0 - state)

    def regressor(self, motion: Motion) -> Array:
        """Return the actuator's torque times its heat."""
        return motion.actuated(self.actuator, motion.effort(self.actuator) * self.recalled(motion))

    def shapes(self, motion: Motion) -> tuple[ThermalDerating, ...]:
        """Return a few rates about one heating a run, at the torque that was typical."""
        typical = float(np.sqrt(np.mean(motion.effort(self.actuator) ** 2)))
        level = float(np.clip(typical, 1e-6, UNLIMITED))
        run = float(motion.time[-1] - motion.time[0])
        return tuple(replace(self, level=level, rate=min(r / run, 1e3)) for r in RATES)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force = "N" if slide else "N m"
        return (
            f"Actuator {self.actuator} falls to {100 * self.floor:.3g} % of its torque as it gets "
            f"hot, at {self.rate:.3g} /s under {self.level:.3g} {force}: its derating by heat was "
            "left out."
        )
