"""Something that a joint runs into."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from morph.arrays import Array, Mask
from morph.physics.effect import Simulations, parameter
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion

DEPTHS = (0.001, 0.0025, 0.005, 0.01, 0.02, 0.06, 0.15)
"""How far into a recording's range to try a stop, as shares of the range."""

ELSEWHERE = (0.1, 0.3, 3.0)
"""The same, as factors of the depth at which a refit ended."""


@dataclass(frozen=True, kw_only=True)
class EndStop(JointEffect):
    """A stiff, damped, one-sided spring: tau = -side max(k p + d dp/dt, 0) for p > 0.

    p = side (q - q_stop) is how deep the joint is in the stop. MuJoCo's own limits are told
    by a time constant and push in proportion to the inertia behind them; this one is told in
    units of force, and acts before each step: it needs a step below 2 sqrt(inertia / k).

    Source: the spring and dashpot in Gilardi and Sharf 2002, Mechanism and Machine Theory
    37(10), cut off where it would pull.
    """

    name: ClassVar[str] = "end_stop"
    strengths: ClassVar[tuple[str, ...]] = ("k", "d")
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("torque_saturation", "external_push")
    excited_by: ClassVar[str] = "Motion into the stop, slowly and fast."
    separate_by: ClassVar[dict[str, str]] = {
        "torque_saturation": "The same command at another position: a stop stays where it is.",
        "external_push": "Come to the same position twice: a stop is there every time.",
        "ground": "Come down in two poses: a floor stops at a height, a joint at an angle.",
    }

    joint: str
    """Joint it acts on."""
    q_stop: float = parameter(0.0, unit="rad", low=-1000.0, high=1000.0)
    """Position at which the stop begins (m on a slide)."""
    side: float = parameter(1.0, unit="-", low=-1.0, high=1.0, scan=(-1.0, 1.0), free=False)
    """Which way it blocks: above 0 what lies past `q_stop`, else what lies before it."""
    k: float = parameter(0.0, unit="N m/rad", low=0.0, high=1e7, neutral=0.0)
    """Stiffness (N/m on a slide)."""
    d: float = parameter(0.0, unit="N m s/rad", low=0.0, high=1e6, neutral=0.0)
    """Damping while it is touched (N s/m on a slide)."""

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Push the joint back out of the stop."""
        place, speed = simulations.position(self.joint), simulations.velocity(self.joint)
        push = self.k * (place - self.q_stop) + self.d * speed
        simulations.force(self.joint)[:] -= np.where(self._pushes(place, speed), push, 0.0)
        return state

    def regressor(self, motion: Motion) -> Array:
        """Return minus the depth and minus its rate, where the stop pushes."""
        place, speed = motion.place(self.joint), motion.speed(self.joint)
        pushes = self._pushes(place, speed)
        return motion.along(self.joint, -(place - self.q_stop) * pushes, -speed * pushes)

    def _pushes(self, place: Array, speed: Array) -> Mask:
        """Return where the joint is in the stop, and not drawn into it."""
        side = np.where(np.asarray(self.side) > 0.0, 1.0, -1.0)
        deep, rate = side * (place - self.q_stop), side * speed
        return np.asarray((deep > 0.0) & (self.k * deep + self.d * rate >= 0.0))

    def shapes(self, motion: Motion) -> tuple[EndStop, ...]:
        """Return stops on either side a little within the recorded range."""
        place = motion.place(self.joint)
        low, high = float(place.min()), float(place.max())
        depths = [share * (high - low) for share in DEPTHS]
        above = tuple(replace(self, side=1.0, q_stop=high - depth) for depth in depths)
        return above + tuple(replace(self, side=-1.0, q_stop=low + depth) for depth in depths)

    def restarts(self, motions: Sequence[Motion]) -> tuple[EndStop, ...]:
        """Return stops that the joint runs less and more deeply into, and that push as much."""
        side = 1.0 if self.side > 0.0 else -1.0
        most = max(float(np.max(side * motion.place(self.joint))) for motion in motions)
        depth = max(most - side * self.q_stop, 0.0)
        return tuple(
            replace(self, q_stop=side * (most - share * depth), k=min(self.k / share, 1e7))
            for share in (ELSEWHERE if depth else ())
        )

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, length = ("N", "m") if slide else ("N m", "rad")
        way = "above" if self.side > 0.0 else "below"
        return (
            f"Joint {self.joint} is pushed back by {self.k:.3g} {force} for each {length} that it "
            f"is {way} {self.q_stop:.3g} {length}: an end stop was left out."
        )
