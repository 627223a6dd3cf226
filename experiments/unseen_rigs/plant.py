"""What a rig is: a description, and what that lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from morph.arrays import Array


@dataclass(frozen=True, kw_only=True)
class Foot:
    """A point of a link that may touch the floor at height 0."""

    joint: str
    """The joint whose link it is on."""
    place: tuple[float, float, float]
    """The middle of a ball, in the link's frame, m."""
    radius: float
    """Of that ball, m."""
    mu: float = 0.8
    """Friction against the floor."""


@dataclass(frozen=True, kw_only=True)
class Push:
    """A constant force at the middle of a free base."""

    start: float
    """s."""
    end: float
    """s."""
    force: tuple[float, float, float]
    """In the world's axes, N."""


@dataclass(frozen=True, kw_only=True)
class Plant:
    """What is simulated: a description's dynamics and what it lacks."""

    description: Path
    """MJCF, whose masses, joints and armatures are taken."""
    motors: Mapping[str, tuple[Array, Array, str]] = field(default_factory=dict)
    """Of each motor a force and a place in the frame of the link of a joint; others are torques
    of the joint of their name."""
    damping: Mapping[str, float] = field(default_factory=dict)
    """Of some joints, as described, N m s/rad."""
    feet: Sequence[Foot] = ()
    """Where it may touch the floor."""
    wet: bool = False
    """Whether it is in water."""
    drag: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)
    """Of the links of some joints a place, and quadratic drag along their axes there, N s2/m2."""
    carried: tuple[str, float, tuple[float, float, float]] | None = None
    """A joint, and a mass that its link carries at a place, kg and m."""
    weak: Mapping[str, float] = field(default_factory=dict)
    """Of some motors, by how much they are weaker."""
    push: Push | None = None
    """A push."""
    gap: tuple[str, float, float] | None = None
    """A joint whose motor has play, rad, and its rotor's inertia, kg m2."""
    loop: tuple[str, Array, str, Array] | None = None
    """Two joints and places on their links that coincide."""


@dataclass(frozen=True, kw_only=True)
class Moved:
    """What a plant did."""

    time: Array
    """Of readings, shape (readings,), s."""
    position: Array
    """Configurations as pinocchio has them, shape (readings, nq)."""
    spin: Array
    """Of the base in its axes, shape (readings, 3), rad/s."""
    pull: Array
    """What an accelerometer reads at the base's origin, mean of the time since the last reading,
    shape (readings, 3), m/s2."""
    effort: Mapping[str, Array]
    """Torque at each joint that a motor turns, shape (readings,), N m."""
    told_at: Array
    """Of commands, shape (commands,), s."""
    told: Mapping[str, Array]
    """Of each motor, shape (commands,)."""
