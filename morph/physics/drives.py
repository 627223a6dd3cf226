"""Forces of actuators along a motion."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.actuators import driven_joint, strength
from morph.physics.dynamics import transmissions


@dataclass(frozen=True, kw_only=True, eq=False)
class Transmission:
    """How actuators act on joints along a motion."""

    length: Array
    """Length of each actuator, in its own unit, shape (samples, actuators)."""
    moment: Array
    """Generalized force by the force of each, shape (samples, actuators, dofs); one sample where
    it is the same everywhere."""

    @classmethod
    def along(cls, model: mujoco.MjModel, pose: Array) -> Transmission:
        """Return the transmission along a motion.

        It is constant where all actuators drive hinges and slides. The moments of tendons,
        thrusters and the like depend on the pose.

        Args:
            model: The model.
            pose: `qpos`, shape (samples, nq).

        Raises:
            KernelError: There is no C compiler, or it fails.
        """
        joints = [driven_joint(model, actuator) for actuator in range(model.nu)]
        driven = [joint for joint in joints if joint is not None]
        if len(driven) < model.nu:
            length, moment = transmissions(model, pose)
            return cls(length=length, moment=moment)
        gear = model.actuator_gear[:, 0]
        moment = np.zeros((1, model.nu, model.nv))
        moment[0, np.arange(model.nu), model.jnt_dofadr[driven]] = gear
        return cls(length=gear * pose[:, model.jnt_qposadr[driven]], moment=moment)

    def by_effort(self, model: mujoco.MjModel) -> Array:
        """Return generalized forces by the effort of each, which its gear has made of its force."""
        efforts = np.array([strength(model, actuator) for actuator in range(model.nu)])
        return np.asarray(self.moment / efforts[:, None])

    def rate(self, velocity: Array) -> Array:
        """Return how fast lengths change, shape (samples, actuators)."""
        if len(self.moment) == 1:
            return np.asarray(velocity @ self.moment[0].T)
        return np.asarray(np.matmul(self.moment, velocity[:, :, None])[..., 0])

    def forces(self, force: Array) -> Array:
        """Return generalized forces by the actuators' own, shape (samples, dofs)."""
        if len(self.moment) == 1:
            return np.asarray(force @ self.moment[0])
        return np.asarray(np.matmul(force[:, None], self.moment)[:, 0])


def actuator_forces(
    model: mujoco.MjModel, transmission: Transmission, velocity: Array, command: Array
) -> Array:
    """Return the actuators' own forces within their limits, shape (samples, actuators).

    Args:
        model: The model; its actuators have no activation of their own.
        transmission: Along the motion.
        velocity: Per s, shape (samples, dofs).
        command: Controls, shape (samples, actuators).
    """
    gain, bias = model.actuator_gainprm[:, 0], model.actuator_biasprm
    force = gain * clamped(command, model.actuator_ctrllimited, model.actuator_ctrlrange)
    force += bias[:, 0] + bias[:, 1] * transmission.length
    force += bias[:, 2] * transmission.rate(velocity)
    return clamped(force, model.actuator_forcelimited, model.actuator_forcerange)


def clamped(values: Array, limited: Array, ranges: Array) -> Array:
    """Return values within their ranges, where they are limited."""
    low = np.where(limited, ranges[:, 0], -np.inf)
    return np.clip(values, low, np.where(limited, ranges[:, 1], np.inf))
