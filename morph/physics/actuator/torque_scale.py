"""An actuator that gives more or less than it is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from morph.arrays import Array
from morph.physics.effect import parameter
from morph.physics.kinds import ActuatorEffect
from morph.physics.motion import Motion


@dataclass(frozen=True, kw_only=True)
class TorqueScale(ActuatorEffect):
    """An actuator produces gain times what was commanded.

    Source: Swevers, Verdonck and De Schutter 2007, IEEE Control Systems 27(5), eq. 4.
    """

    name: ClassVar[str] = "torque_scale"
    strengths: ClassVar[tuple[str, ...]] = ("gain",)
    twins: ClassVar[tuple[str, ...]] = ("link_inertia", "payload")
    excited_by: ClassVar[str] = "Rest under constant commands, beside free swinging."
    separate_by: ClassVar[dict[str, str]] = {
        "armature": "Rest under a constant command, beside fast reversals.",
    }

    actuator: str
    """Actuator it acts on."""
    gain: float = parameter(
        1.0, unit="-", low=-10.0, high=10.0, neutral=1.0, scan=(0.55, 0.8, 1.25, 1.6)
    )
    """Produced over commanded; below 0 the command has the wrong sign."""

    def edit(self, spec: Any) -> None:
        """Scale the actuator's gain and bias; a command of the wrong sign turns no servo's bias."""
        actuator = spec.actuator(self.actuator)
        actuator.gainprm = actuator.gainprm * self.gain
        # MuJoCo reads a rate gain above 0 as a damping ratio.
        actuator.biasprm = actuator.biasprm * abs(self.gain)

    def regressor(self, motion: Motion) -> Array:
        """Return the actuator's nominal force."""
        return motion.actuated(self.actuator, motion.effort(self.actuator))

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        produced = f"{100 * abs(self.gain):.4g} % of what is commanded"
        if self.gain < 0.0:
            return (
                f"Actuator {self.actuator} produces {produced}, the other way: the sign of its "
                "command or of its joint's sensor is wrong."
            )
        return f"Actuator {self.actuator} produces {produced}: its torque constant or gear is off."
