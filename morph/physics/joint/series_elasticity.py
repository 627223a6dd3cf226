"""A spring between a motor and its link."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from scipy.signal import lfilter

from morph.arrays import Array
from morph.physics.effect import UNLIMITED, Simulations, parameter
from morph.physics.joint.motor_side import Motors, MotorSideEffect
from morph.physics.motion import Motion

BENDS = (0.003, 0.01, 0.03, 0.1)
"""How far the spring bends under the typical effort, as shares of the joint's range."""
FINE = 0.5
"""Angle of the rotor's own swing, rad, that a step along a recording may take."""
MOST = 40
"""Most steps between two samples of a recording."""


@dataclass(frozen=True, kw_only=True)
class SeriesElasticity(MotorSideEffect):
    """A spring and a damper carry the motor: tau = k (q_m - q) + d (v_m - v), J dv_m/dt = u - tau.

    q_m and v_m are of the rotor, J its inertia, u what the motor produces. Both sides step
    alternately, as MuJoCo steps its own joints. Where the rotor is so light that its swing
    on the spring is too fast for the step, it is stepped with the inertia k h^2 / 2. A run
    starts with the spring wound by what the motor produces at rest.

    Source: Spong 1987, J. Dynamic Systems, Measurement, and Control 109(4), the reduced model
    of section 2; with a damper as in De Luca and Book 2016, Springer Handbook of Robotics,
    section 11.1.
    """

    name: ClassVar[str] = "series_elasticity"
    strengths: ClassVar[tuple[str, ...]] = ("k",)
    suspected: ClassVar[bool] = False
    twins: ClassVar[tuple[str, ...]] = ("backlash", "actuator_delay", "actuator_lag")
    excited_by: ClassVar[str] = "Steps of the command, and commands near the swing of the spring."
    separate_by: ClassVar[dict[str, str]] = {
        "backlash": "Steps of the command about a loaded rest, so that the load keeps its sign: "
        "play does not show there.",
        "actuator_delay": "A push on the link by hand with the motor held: a spring gives.",
        "actuator_lag": "A push on the link by hand with the motor held: a spring gives.",
    }

    joint: str
    """Joint it acts on."""
    k: float = parameter(UNLIMITED, unit="N m/rad", low=1e-3, high=UNLIMITED, neutral=UNLIMITED)
    """Stiffness (N/m on a slide); at its greatest value motor and link are one."""
    d: float = parameter(0.0, unit="N m s/rad", low=0.0, high=1e5)
    """Damping of the spring (N s/m on a slide)."""

    def initial_state(self, simulations: Simulations) -> Any:
        """Return nothing yet: the spring is wound by the first command."""
        return ()

    def before_step(self, simulations: Simulations, state: Any) -> Any:
        """Let the spring pull in place of the motor, and step the rotor."""
        rigid = np.asarray(self.k) >= UNLIMITED
        if rigid.all():
            return state
        place, speed = simulations.position(self.joint), simulations.velocity(self.joint).copy()
        if not state:
            motors = self.produced(simulations, place, speed)
            wound = motors.torque / (self.k + motors.stiffness)
            state = (place + wound, speed), speed
        rotor, before = state
        motors = self.produced(simulations, *rotor)
        for motor in self.motors(simulations):
            simulations.detach(motor)
        armature = simulations.armature(self.joint)
        spring = _Spring(k=self.k, d=self.d, J=armature.copy(), h=simulations.step)
        tau, after = spring.step(rotor, (place, speed, speed - before), motors)
        self.transmit(simulations, np.where(rigid, motors.torque, tau))
        armature[:] = np.where(rigid, armature, 0.0)
        return (np.where(rigid, place, after[0]), np.where(rigid, speed, after[1])), speed

    def regressor(self, motion: Motion) -> Array:
        """Return what the spring changes of the force on the link, times k.

        It is nearly in proportion to 1 / k. For a stiff joint it is the limit: the rotor
        lags by what it carries, (u - J dv/dt) / k, and misses its inertia, its servo's
        stiffness and damping along this lag.
        """
        effort, (stiffness, damping), inertia = self.recorded(motion)
        rotor = inertia * motion.acceleration[:, motion.joints[self.joint]]
        if self.k < UNLIMITED:
            carried = self._carried(motion, effort, stiffness, damping, inertia)
            return motion.along(self.joint, self.k * (carried + rotor - effort))
        lag = effort - rotor
        rate = np.gradient(lag, motion.time)
        swing = np.gradient(rate, motion.time)
        return motion.along(self.joint, -(inertia * swing + damping * rate + stiffness * lag))

    def _carried(
        self, motion: Motion, effort: Array, stiffness: Any, damping: Any, inertia: float
    ) -> Array:
        """Return what the spring carries along a recording, shape (samples,)."""
        steps = np.diff(motion.time, append=2.0 * motion.time[-1] - motion.time[-2])
        fastest = np.sqrt((self.k + stiffness) / max(inertia, 1e-12)) * steps.max() / FINE
        parts = int(np.clip(np.ceil(fastest), 1, MOST))
        h = float(np.mean(steps)) / parts
        fine = motion.time[0] + h * np.arange(parts * len(steps))
        q, u, rate = (
            np.interp(fine, motion.time, each)
            for each in (motion.place(self.joint), effort, motion.speed(self.joint))
        )
        late = motion.arriving(self.joint)
        coming = np.append(late[1:], late[-1])
        v = np.column_stack([late, *[coming] * (parts - 1)]).reshape(-1)
        given = np.stack([q, u, rate, v, np.diff(v, prepend=v[:1])], axis=1)
        # The rotor is linear in its state and in what is given: its columns are its responses.
        r, s, *units = np.eye(7)
        torque = units[1] - stiffness * (r - units[0]) - damping * (s - units[2])
        motors = Motors(torque=torque, stiffness=stiffness, damping=damping)
        spring = _Spring(k=self.k, d=self.d, J=inertia, h=h)
        tau, (place, speed) = spring.step((r, s), (units[0], units[3], units[4]), motors)
        forced = given @ np.stack([place[2:], speed[2:]], axis=1)
        (a, b), (c, d) = place[:2], speed[:2]
        wound = q[0] + effort[0] / (self.k + stiffness), late[0]
        push, kick = np.vstack([wound, forced[:-1]]).T
        # (1 - A / z)^-1, A of the rotor's own motion, as two filters of second order.
        own = 1.0, -(a + d), a * d - b * c
        x = lfilter([1.0, -d], own, push) + lfilter([0.0, b], own, kick)
        y = lfilter([0.0, c], own, push) + lfilter([1.0, -a], own, kick)
        carried = np.stack([x, y], axis=1) @ tau[:2] + given @ tau[2:]
        return np.asarray(carried.reshape(-1, parts).mean(axis=1))

    @property
    def coefficients(self) -> Array:
        """How far the spring gives: 1 / k."""
        return np.array([1.0 / self.k if self.k < UNLIMITED else 0.0])

    def with_strengths(self, coefficients: Array) -> SeriesElasticity:
        """Return the spring that gives so much; one that cannot give is rigid."""
        gives = max(float(coefficients[0]), 1.0 / UNLIMITED)
        return replace(self, k=float(np.clip(1.0 / gives, 1e-3, UNLIMITED)))

    def shapes(self, motion: Motion) -> tuple[SeriesElasticity, ...]:
        """Return springs that bend by a few shares of the recorded range."""
        effort, *_ = self.recorded(motion)
        typical = float(np.sqrt(np.mean(effort**2))) + 1e-9
        span = float(np.ptp(motion.place(self.joint))) + 1e-9
        stiff = [float(np.clip(typical / (s * span), 1e-3, 0.99 * UNLIMITED)) for s in BENDS]
        return tuple(replace(self, k=k) for k in stiff)

    def statement(self, *, slide: bool = False) -> str:
        """Return the finding in one plain sentence."""
        force, length = ("N", "m") if slide else ("N m", "rad")
        return (
            f"Joint {self.joint} turns against its motor by one {length} for each {self.k:.3g} "
            f"{force} between them: the elasticity of the drive was left out."
        )


@dataclass(frozen=True, kw_only=True)
class _Spring:
    """A spring, a damper and a rotor for one step of h seconds."""

    k: Any
    d: Any
    J: Any
    h: float

    def step(
        self, rotor: tuple[Any, Any], link: tuple[Any, Any, Any], motors: Motors
    ) -> tuple[Any, tuple[Any, Any]]:
        """Return the torque on the link, and the rotor's position and velocity afterwards.

        As in MuJoCo, velocities are those of half a step before. What damps is taken at their
        mean over the step, or later where that would overshoot; of the link, which is not
        known yet, with the change of the step before.

        Args:
            rotor: Its position and velocity before.
            link: Its position and velocity before, and how that changed in the step before.
            motors: What turns the rotor, at its position and velocity before.
        """
        (place, rate), (q, v, change) = rotor, link
        inertia = np.maximum(self.J, 0.5 * (self.k + motors.stiffness) * self.h**2)
        damped = self.h * (self.d + motors.damping)
        share = np.maximum(0.5, 1.0 - inertia / np.maximum(damped, 1e-12))
        known = self.k * (place - q) + self.d * (rate - v - share * change)
        gain = self.h * (motors.torque - known) / (inertia + share * damped)
        after = rate + gain
        return known + self.d * share * gain, (place + self.h * after, after)
