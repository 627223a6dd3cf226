"""A recording as an effect's regressor sees it: smooth motion and the forces along it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np

from morph.arrays import Array
from morph.physics.body_motion import BodyMotion


def _none() -> Array:
    return np.zeros((0, 0))


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Positions, velocities, accelerations and actuator forces, sample by sample."""

    velocity: Array
    """Generalized velocities, shape (samples, degrees of freedom)."""
    position: Array
    """Positions by degree of freedom, zero of rotations in space, same shape."""
    acceleration: Array
    """Generalized accelerations, shape (samples, degrees of freedom)."""
    drive: Array
    """Generalized force of each actuator, shape (samples, actuators, degrees of freedom)."""
    drive_rate: Array
    """How that force changes with time because its command does; same shape, per s."""
    stiffness: Array
    """Change of the force that is needed with each position, (samples, dofs, dofs)."""
    joints: Mapping[str, int]
    """Degree of freedom of each hinge and slide."""
    actuators: Mapping[str, int]
    """Index of each actuator."""
    bodies: Mapping[str, BodyMotion] = field(default_factory=dict)
    """How links move, where effects on links are looked for; for `base_tilt` all of them."""
    time: Array = field(default_factory=_none)
    """When each sample was taken, s, shape (samples,)."""
    command: Array = field(default_factory=_none)
    """What each actuator received, in its own unit, shape (samples, actuators)."""
    driven: Mapping[str, str | None] = field(default_factory=dict)
    """The joint that each actuator drives, by the actuator's name; None of one without a joint."""
    moment: Array = field(default_factory=_none)
    """Generalized force by the effort of each actuator, (samples or 1, actuators, dofs), of which
    those without a joint are looked up."""
    servo: Array = field(default_factory=_none)
    """By how much each actuator's force falls per rad and per rad/s, (actuators, 2)."""
    armature: Array = field(default_factory=_none)
    """Inertia of the rotor on each degree of freedom, in the model, shape (dofs,)."""
    channels: Mapping[str, int] = field(default_factory=dict)
    """Index of each channel."""
    reading: Array = field(default_factory=_none)
    """What each channel reads, shape (samples, channels)."""
    reading_rate: Array = field(default_factory=_none)
    """How that changes with time, same shape, per s."""
    run: str = ""
    """Name of the run."""
    missing: Array = field(default_factory=_none)
    """Generalized force that the model lacks, N m or N, shape (samples, dofs)."""
    pose: Array | None = None
    """MuJoCo's `qpos`, shape (samples, nq); None where that is `position`."""
    senses: Mapping[str, Array] = field(default_factory=dict)
    """What `sign` returns of joints of which that is known, shape (samples,) each."""
    _signs: dict[str, Array] = field(default_factory=dict, init=False, repr=False, compare=False)
    """What `sign` has returned: many effects ask."""

    @property
    def qpos(self) -> Array:
        """Positions as MuJoCo has them, shape (samples, nq)."""
        return self.position if self.pose is None else self.pose

    def along(self, joint: str, *columns: Array) -> Array:
        """Return columns (samples,) as forces on one joint, (samples, dofs, columns)."""
        samples, dofs = self.velocity.shape
        whole = np.zeros((samples, dofs, len(columns)))
        whole[:, self.joints[joint]] = np.stack(columns, axis=-1)
        return whole

    def speed(self, joint: str) -> Array:
        """Return a joint's velocity, shape (samples,)."""
        return np.asarray(self.velocity[:, self.joints[joint]])

    def place(self, joint: str) -> Array:
        """Return a joint's position, shape (samples,)."""
        return np.asarray(self.position[:, self.joints[joint]])

    def arriving(self, joint: str) -> Array:
        """Return a joint's mean velocity since the sample before, shape (samples,).

        It is the velocity that a simulation has at a position: half a step behind.
        """
        rate = np.diff(self.place(joint)) / np.diff(self.time)
        return np.concatenate([self.speed(joint)[:1], rate])

    def drive_speed(self, actuator: str) -> Array:
        """Return the speed of an actuator's joint, shape (samples,); zero without one."""
        joint = self.driven[actuator]
        return np.zeros(len(self.velocity)) if joint is None else self.speed(joint)

    def effort(self, actuator: str) -> Array:
        """Return what an actuator produces, at its joint if it drives one, shape (samples,)."""
        return self._at_joint(actuator, self.drive)

    def effort_rate(self, actuator: str) -> Array:
        """Return how that changes with time because its command does, per s, (samples,)."""
        return self._at_joint(actuator, self.drive_rate)

    def actuated(self, actuator: str, *columns: Array) -> Array:
        """Return columns (samples,) as efforts of one actuator, (samples, dofs, columns)."""
        joint = self.driven[actuator]
        if joint is not None:
            return self.along(joint, *columns)
        moment = self.moment[:, self.actuators[actuator]]
        return np.asarray(moment[:, :, None] * np.stack(columns, axis=-1)[:, None])

    def _at_joint(self, actuator: str, forces: Array) -> Array:
        at, joint = self.actuators[actuator], self.driven[actuator]
        if joint is not None:
            return np.asarray(forces[:, at, self.joints[joint]])
        # Its generalized force is its effort times the moment.
        moment = self.moment[:, at]
        size = np.maximum(np.sum(moment**2, axis=1), np.finfo(float).tiny)
        return np.asarray(np.sum(moment * forces[:, at], axis=1) / size)

    def noticed(self, channel: str, *columns: Array) -> Array:
        """Return columns (samples,) as changes of one reading, (samples, channels, columns)."""
        whole = np.zeros((*self.reading.shape, len(columns)))
        whole[:, self.channels[channel]] = np.stack(columns, axis=-1)
        return whole

    def sign(self, joint: str) -> Array:
        """Return the sense in which dry friction acts on a joint, in [-1, 1], shape (samples,).

        It turns over a ten-thousandth of the joint's range and holds at rest, as
        asperities do that bend before they slip; a sign of the velocity would let go of a joint
        that rests, and follow its noise.

        Source: Prandtl's stop operator, as in Visintin 1994, Differential Models of Hysteresis,
        section III.1.
        """
        if joint in self.senses:
            return self.senses[joint]
        if joint not in self._signs:
            place = self.place(joint)
            moves = np.diff(place) / (1e-4 * float(np.ptp(place)) + 1e-12)
            held, senses = 0.0, [0.0]
            for move in moves.tolist():
                held = min(1.0, max(-1.0, held + move))
                senses.append(held)
            self._signs[joint] = np.array(senses)
        return self._signs[joint]


def actuator_moments(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Return generalized forces by the force of each actuator, shape (actuators, dofs).

    Args:
        model: The compiled robot.
        data: Its state; positions passed forward.
    """
    moments = np.zeros((model.nu, model.nv))
    mujoco.mju_sparse2dense(
        moments, data.actuator_moment, data.moment_rownnz, data.moment_rowadr, data.moment_colind
    )
    return moments
