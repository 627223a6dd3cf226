"""An actuator that gives no more than so much."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array
from morph.body.actuators import leverage
from morph.physics.actuator.limit import LimitEffect
from morph.physics.effect import UNLIMITED, parameter
from morph.physics.motion import Motion

SHARES = (0.01, 0.02, 0.03, *(0.05 * twentieth for twentieth in range(1, 20)))
"""Limits to try, as shares of the greatest torque along a recording."""


@dataclass(frozen=True, kw_only=True)
class TorqueSaturation(LimitEffect):
    """An actuator's torque is clipped at the limit, in both directions.

    Told at the joint, behind the gear; a closer limit of the description stays.

    Source: Khalil 2002, Nonlinear Systems, section 1.2.7 (saturation).
    """

    name: ClassVar[str] = "torque_saturation"
    strengths: ClassVar[tuple[str, ...]] = ("limit",)
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("back_emf", "speed_torque_limit", "torque_scale")
    excited_by: ClassVar[str] = "Commands that grow slowly up to the greatest, with the link held."
    separate_by: ClassVar[dict[str, str]] = {
        "back_emf": "The greatest command with the link held, and again at full speed.",
        "speed_torque_limit": "The greatest command with the link held, and again at full speed.",
        "torque_scale": "Small and great commands with the link held.",
        "end_stop": "The same command at another position: a stop stays where it is.",
    }

    actuator: str
    """Actuator it acts on."""
    limit: float = parameter(UNLIMITED, unit="N m", low=1e-6, high=UNLIMITED, neutral=UNLIMITED)
    """Greatest torque at the joint (N on a slide)."""

    def limits(self, speed: Array) -> tuple[Array, Array]:
        """Return minus and plus the limit at every speed."""
        high = np.broadcast_to(np.asarray(self.limit), speed.shape)
        return -high, high

    def edit(self, spec: Any) -> None:
        """Narrow the actuator's range of forces."""
        if self.limit >= UNLIMITED:
            return
        import mujoco

        actuator = spec.actuator(self.actuator)
        most = self.limit / leverage(np.asarray(actuator.gear), actuator.trntype)
        low, high = -most, most
        limited, auto = actuator.forcelimited, mujoco.mjtLimited.mjLIMITED_AUTO
        known = actuator.forcerange[0] < actuator.forcerange[1]
        if limited == mujoco.mjtLimited.mjLIMITED_TRUE or (limited == auto and known):
            low = max(low, float(actuator.forcerange[0]))
            high = min(high, float(actuator.forcerange[1]))
        actuator.forcelimited, actuator.forcerange = mujoco.mjtLimited.mjLIMITED_TRUE, (low, high)

    def shapes(self, motion: Motion) -> tuple[TorqueSaturation, ...]:
        """Return limits at a few shares of the greatest torque that was recorded."""
        most = float(np.abs(motion.effort(self.actuator)).max()) + 1e-6
        return tuple(replace(self, limit=float(min(share * most, UNLIMITED))) for share in SHARES)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Actuator {self.actuator} gives at most {self.limit:.3g} {'N' if slide else 'N m'} in "
            "either direction: the saturation of its torque was left out."
        )
