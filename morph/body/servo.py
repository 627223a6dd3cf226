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


SERVOS = (
    # kp, limit and armature: TheRobotStudio/SO-ARM100 at 53f2b75,
    # Simulation/SO101/joints_properties.xml. kv: see robots/so101/card.toml.
    Servo(name="STS3215", kp=17.8, kv=1.0, limit=3.35, armature=0.028),
)
"""Every servo known by name."""


def servo(name: str) -> Servo | None:
    """Return a servo by its name, or None if it is not one we know."""
    return next((known for known in SERVOS if known.name == name), None)
