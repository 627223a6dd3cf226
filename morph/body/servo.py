"""Position servos that a card may name as the motor of a joint."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Servo:
    """A position servo as its maker and its users describe it."""

    name: str
    """The maker's name for it."""
    kp: float
    """Torque per position error, N m/rad."""
    kv: float
    """Torque per velocity, N m s/rad."""
    limit: float
    """Greatest torque, N m."""
    armature: float
    """Inertia of its rotor seen at the horn, kg m2."""


DYNAMIXELS = (
    # Stall torque and no-load speed at 12 V, gear ratio: ROBOTIS e-manual, pages mx-28,
    # mx-64, ax-12a and ax-18a. The maker advises loads of a fifth of the stall torque.
    # kv: a DC motor's torque falls from stall to nothing at its no-load speed, so
    # kv = stall / speed: 2.5 / 5.76, 6.0 / 6.60, 1.5 / 6.18, 1.8 / 10.16.
    # kp of the MX: duty cycle per error is 0.158 per rad and unit of P (measured by
    # Rhoban/bam, class MXActuator); at the usual P of 32, kp = 32 * 0.158 * stall.
    # kp of the AX: full torque at the default compliance slope, 32 steps of 0.29
    # degrees, so kp = stall / 0.162 rad.
    # Armature: the MX-64's as identified (Rhoban/bam, params/mx64/m1.json). The maker
    # says of the MX-28 only that its motor is a coreless maxon: it is assumed to be the
    # RE-max 17, with a rotor of 0.868 g cm2, times 193^2. Of the AX no rotor is
    # published; the same one is assumed, times 254^2.
    Servo(name="MX-28", kp=12.6, kv=0.434, limit=2.5, armature=0.00323),
    Servo(name="MX-64", kp=30.3, kv=0.909, limit=6.0, armature=0.012),
    Servo(name="AX-12", kp=9.26, kv=0.243, limit=1.5, armature=0.0056),
    Servo(name="AX-18", kp=11.1, kv=0.177, limit=1.8, armature=0.0056),
)
"""Servos of ROBOTIS as position servos at 12 V."""

SERVOS = (
    # kp, limit and armature: TheRobotStudio/SO-ARM100 at 53f2b75,
    # Simulation/SO101/joints_properties.xml. kv: see robots/so101/card.toml.
    Servo(name="STS3215", kp=17.8, kv=1.0, limit=3.35, armature=0.028),
    *DYNAMIXELS,
)
"""Every servo known by name."""


def servo(name: str) -> Servo | None:
    """Return a servo by its name, or None if it is not one we know."""
    return next((known for known in SERVOS if known.name == name), None)
