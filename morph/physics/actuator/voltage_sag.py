"""A supply that sags under the load of the whole robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.physics.effect import Simulations, parameter
from morph.physics.kinds import ActuatorEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class VoltageSag(ActuatorEffect):
    """Every actuator gives less under load: gain = 1 / (1 + k sum abs(u)) over all of them.

    u is what each would produce at full voltage. It acts on all actuators, whichever it is
    told at: they share one supply. Tell it once.

    Source: the source resistance of Chen and Rincon-Mora 2006, IEEE Trans. Energy Conversion
    21(2), with currents in proportion to torques, solved for the gain to first
    order in the resistance and kept positive.
    """

    name: ClassVar[str] = "voltage_sag"
    strengths: ClassVar[tuple[str, ...]] = ("k",)
    suspected: ClassVar[bool] = False
    everywhere: ClassVar[bool] = True
    twins: ClassVar[tuple[str, ...]] = ("thermal_derating", "torque_scale")
    excited_by: ClassVar[str] = (
        "The same motion of one joint while others rest and while they work."
    )
    separate_by: ClassVar[dict[str, str]] = {
        "thermal_derating": "The same motion at the start and at the end of a long run: sag "
        "depends on the load of the moment.",
        "torque_scale": "The same motion of one joint while others rest and while they work.",
    }

    actuator: str
    """An actuator on the supply; all of them are."""
    k: float = parameter(0.0, unit="1/(N m)", low=0.0, high=1e3, neutral=0.0)
    """Share of the gain that each N m of load takes at first (1/N on a slide)."""

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Weaken every actuator by the load of all."""
        efforts = [simulations.effort(actuator) for actuator in simulations.actuators]
        load = sum((np.abs(effort) for effort in efforts), np.zeros_like(efforts[0]))
        for effort in efforts:
            effort[:] /= 1.0 + self.k * load
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return minus every actuator's torque times the load, at the gain as it stands."""
        load = np.abs(motion.drive).sum(axis=(1, 2))
        total = motion.drive.sum(axis=1)
        return np.asarray(-total * (load / (1.0 + self.k * load))[:, None])[:, :, None]

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Actuator {self.actuator}, with all others on its supply, gives 1 / (1 + "
            f"{self.k:.3g} L) of its torque while their torques together are L "
            f"{'N' if slide else 'N m'}: the sag of the voltage was left out."
        )
