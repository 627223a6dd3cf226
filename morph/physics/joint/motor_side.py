"""The motor's side of a joint: what effects between a motor and its link have in common."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from morph.arrays import Array
from morph.body.robot import Robot
from morph.physics.kinds import JointEffect
from morph.physics.motion import Motion
from morph.physics.simulations import Simulations

SMALL = 1e-6
"""Difference, rad and rad/s, by which a servo's stiffness and damping are found."""


@dataclass(frozen=True, kw_only=True)
class Motors:
    """What the motors of a joint produce while its rotor is near a position and a velocity."""

    torque: Array
    """N m, shape (simulations,)."""
    stiffness: Array
    """By how much it falls per rad that the rotor is further."""
    damping: Array
    """By how much it falls per rad/s that the rotor is faster."""


class MotorSideEffect(JointEffect):
    """An effect between the motor of a joint and its link.

    The rotor is the inertia that the model has on the joint: `armature`, of the description
    and of effects. It has a position and a velocity of its own, which the effect remembers,
    and servos close on it. Friction and damping of the joint, and its sensors, stay with the
    link. Of the robot the rotor feels this joint alone.
    """

    @classmethod
    def places(cls, robot: Robot) -> tuple[str, ...]:
        """Return the hinges and slides that a motor drives."""
        driven = set(robot.driven)
        return tuple(joint.name for joint in robot.joints if joint.name in driven)

    def motors(self, simulations: Simulations) -> list[str]:
        """Return the actuators of the joint."""
        return [a for a, joint in simulations.actuators.items() if joint == self.joint]

    def produced(self, simulations: Simulations, position: Array, velocity: Array) -> Motors:
        """Return what the motors produce with the rotor there, in the coming step.

        What other effects have made of their effort stays; servos are read at the rotor.
        """
        motors = self.motors(simulations)
        here, speed = simulations.position(self.joint), simulations.velocity(self.joint)

        def at(place: Array, rate: Array) -> Array:
            torques = (simulations.torque(motor, place, rate) for motor in motors)
            return np.asarray(sum(torques, np.zeros_like(here)))

        effort = sum((simulations.effort(motor) for motor in motors), np.zeros_like(here))
        there = at(position, velocity)
        return Motors(
            torque=effort + (there - at(here, speed)),
            stiffness=(there - at(position + SMALL, velocity)) / SMALL,
            damping=(there - at(position, velocity + SMALL)) / SMALL,
        )

    def transmit(self, simulations: Simulations, torque: Array) -> None:
        """Let the link feel a torque in place of what its motors produce."""
        first, *others = self.motors(simulations)
        simulations.effort(first)[:] = torque
        for motor in others:
            simulations.effort(motor)[:] = 0.0

    def recorded(self, motion: Motion) -> tuple[Array, Array, float]:
        """Return the motors along a recording.

        Returns:
            What they produced at the link's own motion, shape (samples,); by how much that
            falls per rad and per rad/s, shape (2,); and the rotor's inertia.
        """
        dof = motion.joints[self.joint]
        motors = [motion.actuators[a] for a, joint in motion.driven.items() if joint == self.joint]
        servo = motion.servo[motors].sum(axis=0)
        return motion.drive[:, motors, dof].sum(axis=1), servo, float(motion.armature[dof])
