"""A recording as an effect's regressor sees it: smooth motion and the forces along it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from morph.arrays import Array
from morph.physics.body_motion import BodyMotion


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Positions, velocities, accelerations and actuator forces, sample by sample."""

    velocity: Array
    """Generalized velocities, shape (samples, degrees of freedom)."""
    position: Array
    """Joint positions, shape (samples, degrees of freedom)."""
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
    """How links move, where effects on links are looked for."""

    def along(self, joint: str, *columns: Array) -> Array:
        """Return columns (samples,) as forces on one joint, (samples, dofs, columns)."""
        samples, dofs = self.velocity.shape
        whole = np.zeros((samples, dofs, len(columns)))
        whole[:, self.joints[joint]] = np.stack(columns, axis=-1)
        return whole

    def speed(self, joint: str) -> Array:
        """Return a joint's velocity, shape (samples,)."""
        return np.asarray(self.velocity[:, self.joints[joint]])

    def sign(self, joint: str) -> Array:
        """Return the sense of a joint's motion, in [-1, 1], fading near rest.

        Smoothed positions cannot tell rest from slow motion: below a hundredth of
        the joint's typical speed the sign fades linearly to zero.
        """
        speed = self.speed(joint)
        slow = 0.02 * float(np.sqrt(np.mean(speed**2))) + 1e-9
        return np.clip(speed / slow, -1.0, 1.0)
