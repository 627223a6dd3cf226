"""Play between a motor and its link."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array, Mask
from morph.physics.effect import Simulations, parameter
from morph.physics.joint.motor_side import Motors, MotorSideEffect
from morph.physics.joint.recorded import followed_backlash
from morph.physics.motion import Motion
from morph.physics.stacked import stacked

GAPS = (0.001, 0.002, 0.003, 0.006, 0.01, 0.02, 0.03, 0.06, 0.1)
"""Gaps to try, as shares of the joint's range in a recording."""
LIGHT = 1e-12
"""Inertia of a rotor that has none, kg m2: it crosses a gap within a step."""


@dataclass(frozen=True, kw_only=True)
class Backlash(MotorSideEffect):
    """Between motor and link is play: abs(q_m - q) <= gap / 2, and no torque but at its ends.

    In the gap the rotor turns by itself, J dv_m/dt = u, and the link has neither its torque
    nor its inertia. At an end the teeth are rigid: rotor and link turn as one while the
    motor pushes the link that way, u - J dv/dt, and meet without bouncing, so that momentum
    stays and energy is lost. Contact is decided before each step, by the acceleration of the
    step before. A run starts at the end to which the motor pushes.

    Source: Nordin and Gutman 2002, Automatica 38(10), section 2, with teeth that are rigid.
    """

    name: ClassVar[str] = "backlash"
    strengths: ClassVar[tuple[str, ...]] = ("gap",)
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("series_elasticity", "dead_zone", "hysteresis")
    excited_by: ClassVar[str] = "Reversals of the motor's torque, with little load and much."
    separate_by: ClassVar[dict[str, str]] = {
        "series_elasticity": "Steps of the command about a loaded rest, so that the load keeps its "
        "sign: play does not show there.",
        "dead_zone": "Small commands about a loaded rest: a dead zone is felt under load too.",
        "hysteresis": "Small reversals of the command about a loaded rest: hysteresis gives at "
        "once, play does not show there.",
        "stribeck_friction": "Reversals with the link held by its weight on one side: play does "
        "not show there, friction does.",
    }

    joint: str
    """Joint it acts on."""
    gap: float = parameter(0.0, unit="rad", low=0.0, high=3.0, neutral=0.0)
    """Play from one end to the other (m on a slide)."""

    def initial_state(self, simulations: Simulations) -> Any:
        """Return nothing yet: the first torque says at which end the rotor is."""
        return ()

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Let the link feel the motor where teeth touch, and step the rotor where not."""
        plays = np.asarray(self.gap) > 0.0
        if not plays.any():
            return state
        place, speed = simulations.position(self.joint), simulations.velocity(self.joint).copy()
        if not state:
            push = self.produced(simulations, place, speed).torque
            state = _Rotor.at_end(push, self.gap, speed), speed
        rotor, before = state
        rate = np.where(rotor.side != 0.0, speed, rotor.rate)
        motors = self.produced(simulations, place + rotor.ahead, rate)
        armature, slope = simulations.armature(self.joint), (speed - before) / simulations.step
        felt, loose, rotor = rotor.step(motors, armature, speed, slope, simulations.step)
        whole = sum(simulations.effort(motor) for motor in self.motors(simulations))
        self.transmit(simulations, np.where(plays, felt, whole))
        armature[:] = np.where(plays & loose, 0.0, armature)
        return rotor, speed

    def regressor(self, motion: Motion) -> Array:
        """Return what the play changes of the force on the link, for each rad of the gap."""
        effort, (stiffness, damping), inertia = self.recorded(motion)
        gap = np.atleast_1d(self.gap)
        plays = gap > 0.0
        change = followed_backlash(
            effort,
            motion.arriving(self.joint),
            motion.speed(self.joint),
            motion.acceleration[:, motion.joints[self.joint]],
            np.diff(motion.time, append=2.0 * motion.time[-1] - motion.time[-2]),
            motors=(stiffness, damping),
            inertia=(inertia, LIGHT),
            gap=gap,
        )
        return motion.along(self.joint, *np.where(plays, change / np.where(plays, gap, 1.0), 0.0).T)

    @classmethod
    def regressors(cls, shapes: Sequence[Backlash], motion: Motion) -> Array:
        """Return the regressors of several gaps, followed together."""
        return stacked(shapes).regressor(motion)

    def shapes(self, motion: Motion) -> tuple[Backlash, ...]:
        """Return gaps of a few shares of the recorded range."""
        span = float(np.ptp(motion.place(self.joint))) + 1e-9
        return tuple(replace(self, gap=float(min(share * span, 3.0))) for share in GAPS)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        return (
            f"Joint {self.joint} has {self.gap:.3g} {'m' if slide else 'rad'} of play between its "
            "motor and its link: backlash was left out."
        )


@dataclass(frozen=True, kw_only=True)
class _Rotor:
    """A rotor in a gap, of one simulation or of many."""

    gap: Any
    """From one end to the other, rad."""
    side: Array
    """The end that it is at, -1 or 1, or 0."""
    ahead: Array
    """Its position less the link's, rad."""
    rate: Array
    """Its velocity while it is at no end, rad/s."""
    met: Mask
    """Whether it met the end in the step before."""

    @classmethod
    def at_end(cls, push: Array, gap: Any, speed: Array) -> _Rotor:
        """Return a rotor at the end to which it is pushed."""
        side = np.where(push < 0.0, -1.0, 1.0)
        met = np.zeros_like(side, dtype=bool)
        return cls(gap=gap, side=side, ahead=0.5 * side * gap, rate=speed, met=met)

    def step(
        self, motors: Motors, inertia: Array, speed: Array, slope: Array, h: float
    ) -> tuple[Array, Mask, _Rotor]:
        """Return what the link feels, whether the rotor is off it, and the rotor afterwards.

        Args:
            motors: What turns the rotor.
            inertia: Of the rotor, kg m2.
            speed: Of the link, rad/s.
            slope: The link's acceleration in the step before, rad/s2.
            h: Seconds a step.
        """
        u = motors.torque
        # What an impact does to the link says nothing of the step that follows it.
        slope = np.where(self.met, 0.0, slope)
        pushes = (self.side != 0.0) & (self.side * (u - inertia * slope) >= 0.0)
        rate = np.where(self.side != 0.0, speed, self.rate)
        heavy = np.maximum(inertia, LIGHT)
        after = rate + h * u / (heavy + h * motors.damping + h**2 * motors.stiffness)
        ahead = self.ahead + h * (after - (speed + h * slope))
        meets = ~pushes & (np.abs(ahead) >= 0.5 * self.gap)
        felt = np.where(pushes, u, np.where(meets, heavy * (after - speed) / h, 0.0))
        side = np.where(pushes, self.side, np.where(meets, np.sign(ahead), 0.0))
        place = np.clip(ahead, -0.5 * self.gap, 0.5 * self.gap)
        place = np.where(pushes, self.ahead, place)
        rotor = _Rotor(gap=self.gap, side=side, ahead=place, rate=after, met=meets)
        return felt, ~pushes & ~meets, rotor
