"""A mechanism: a nominal plant, the names of its parts, and how it is driven and excited."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.concealed.plant import Array, Plant, plant_of

STANDARD_GRAVITY = 9.80665
"""m/s2, ISO 80000-3."""
NONE, TORQUE, SERVO = 0, 1, 2


@dataclass(frozen=True, kw_only=True)
class Link:
    """One link with its joint, every vector along the world's axes at q = 0."""

    axis: tuple[float, float, float]
    """Direction of the joint."""
    reach: tuple[float, float, float]
    """From this joint to the next one or to the tip, m."""
    mass: float
    """kg."""
    slide: bool = False
    """Whether the joint is a slide."""
    thickness: float = 0.03
    """Radius of the link, m."""
    drive: int = TORQUE
    """`NONE`, `TORQUE` or `SERVO`."""
    rotor: float = 0.0
    """Inertia of the rotor through the gear, kg m2 or kg."""
    damping: float = 0.0
    """Viscous friction that the description states."""
    home: float = 0.0
    """Position about which it is moved."""
    span: float = 0.7
    """Largest excursion from there."""


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """What the description states, and how an experimenter excites it."""

    family: str
    """Name of the kind of mechanism."""
    plant: Plant
    """The description's figures, drives included."""
    links: tuple[str, ...]
    """Names of the bodies."""
    joints: tuple[str, ...]
    """Names of the joints; an actuator has its joint's name with `_drive`."""
    home: Array
    """Posture about which it is moved, shape (n,)."""
    span: Array
    """Largest excursions, shape (n,)."""
    rate: float
    """Highest frequency of slow excitation, Hz."""
    submerged: bool
    """Whether it works in water."""
    coasts: bool
    """Whether its drives may be cut off without harm: gravity brings it back."""

    @property
    def driven(self) -> tuple[int, ...]:
        """Indices of the joints with a drive."""
        return tuple(int(i) for i in np.flatnonzero(self.plant.of_joint("drive")))

    def actuator(self, joint: int) -> str:
        """Return the name of a joint's actuator."""
        return f"{self.joints[joint]}_drive"


def random_rotation(rng: np.random.Generator) -> Array:
    """Return a rotation drawn uniformly, from a unit quaternion, shape (3, 3)."""
    w, x, y, z = (q := rng.standard_normal(4)) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def chain(links: Sequence[Link], rng: np.random.Generator) -> Plant:
    """Return a chain of links in frames of random orientation, without drives.

    A link's mass is a rod along its reach, a little off its middle, with a random cross-section.
    """
    n = len(links)
    frames = [random_rotation(rng) for _ in links]
    rotation, origin, axis = np.zeros((n, 3, 3)), np.zeros((n, 3)), np.zeros((n, 3))
    com, inertia = np.zeros((n, 3)), np.zeros((n, 3, 3))
    for i, link in enumerate(links):
        before = frames[i - 1] if i else np.eye(3)
        reach = np.array(link.reach)
        along = reach / np.linalg.norm(reach)
        across = np.eye(3) - np.outer(along, along)
        rod = np.linalg.norm(reach) ** 2 / 12 * across
        thick = link.thickness**2 * (across / 4 + np.outer(along, along) / 2)
        aside = random_rotation(rng) @ np.diag(rng.uniform(0.02, 0.1, 3)) * link.thickness**2
        solid = link.mass * (rod + thick + aside @ aside.T / link.thickness**2)
        middle = rng.uniform(0.4, 0.6) * reach + 0.1 * link.thickness * rng.standard_normal(3)
        rotation[i] = before.T @ frames[i]
        origin[i] = before.T @ (np.array(links[i - 1].reach) if i else np.zeros(3))
        unit = np.array(link.axis) / np.linalg.norm(link.axis)
        axis[i], com[i] = frames[i].T @ unit, frames[i].T @ middle
        inertia[i] = frames[i].T @ solid @ frames[i]
    return plant_of(
        parent=np.arange(n) - 1, slide=np.array([int(link.slide) for link in links]),
        rotation=rotation, origin=origin, axis=axis,
        mass=np.array([link.mass for link in links]), com=com, inertia=inertia,
        gravity=np.array([0.0, 0.0, -STANDARD_GRAVITY]),
    )  # fmt: skip


def drive(plant: Plant, links: Sequence[Link], servo_rate: float, track_rate: float) -> Plant:
    """Return the plant with its drives, whose gains suit the inertia that each joint moves.

    Args:
        plant: The chain.
        links: Its links.
        servo_rate: Bandwidth of position servos, Hz.
        track_rate: Bandwidth of the logger's own controller of torque drives, Hz.
    """
    home = np.array([link.home for link in links])
    mass, _ = plant.mass_and_bias(home[None], 0 * home[None])
    rotor = np.array([link.rotor for link in links])
    moved = np.diag(mass[0]) + rotor
    kind = np.array([link.drive for link in links], dtype=float)
    servo, track = 2 * np.pi * servo_rate, 2 * np.pi * track_rate
    return plant.with_joint(
        slice(None),
        rotor=rotor,
        viscous=np.array([link.damping for link in links]),
        drive=kind,
        kp=np.where(kind == SERVO, moved * servo**2, 0.0),
        kv=np.where(kind == SERVO, 1.4 * moved * servo, 0.0),
        track_p=np.where(kind == TORQUE, moved * track**2, 0.0),
        track_d=np.where(kind == TORQUE, 1.4 * moved * track, 0.0),
    )
