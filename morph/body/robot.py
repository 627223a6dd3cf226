"""A robot: its links, joints and actuators, frozen, with where they came from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from morph.errors import RobotError

if TYPE_CHECKING:
    from morph.body.card import Card
    from morph.body.finding import DescriptionFinding

FREEDOMS = {"hinge": 1, "slide": 1, "ball": 3, "free": 6}
"""Degrees of freedom of each kind of joint."""

Part = TypeVar("Part", "Link", "Joint", "Actuator")


@dataclass(frozen=True, kw_only=True)
class Link:
    """A rigid body."""

    name: str
    """Its name in the description."""
    mass: float
    """Mass, kg."""
    com: tuple[float, float, float]
    """Centre of mass in the link's frame, m."""
    inertia: tuple[float, ...]
    """About the centre of mass, in the link's frame, kg m2: xx, yy, zz, xy, xz, yz."""
    inertia_from: str = "description"
    """Where the inertia comes from: `measured`, `description`, `mesh x density` or `none`."""
    parent: str = "world"
    """The link that it hangs from."""
    shapes: tuple[str, ...] = ()
    """Its shapes, visual first: `visual mesh`, `collision box` and so on."""


@dataclass(frozen=True, kw_only=True)
class Mimic:
    """A joint that follows another: position = ratio * other + offset."""

    joint: str
    """The joint that it follows."""
    ratio: float
    """Movement per movement of the other."""
    offset: float
    """Position where the other is at zero, rad or m."""


@dataclass(frozen=True, kw_only=True)
class Joint:
    """A hinge, a slide, or a free joint."""

    name: str
    """Its name in the description."""
    kind: str
    """`hinge`, `slide`, `ball` or `free`."""
    link: str
    """The link that it moves."""
    limits: tuple[float, float] | None = None
    """Range, rad or m; None if it turns freely."""
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    """What it turns about or slides along, in the link's frame."""
    effort: float | None = None
    """Greatest effort of its motors, N m or N; None if not given."""
    velocity: float | None = None
    """Greatest speed, rad/s or m/s; None if not given; MuJoCo does not hold it."""
    damping: float = 0.0
    """Viscous friction, N m s/rad or N s/m."""
    friction: float = 0.0
    """Dry friction, N m or N."""
    mimic: Mimic | None = None
    """Set if it follows another joint."""

    @property
    def unit(self) -> str:
        """The unit of its position: rad or m."""
        return "m" if self.kind == "slide" else "rad"

    @property
    def effort_unit(self) -> str:
        """The unit of its generalized force."""
        return "N" if self.kind == "slide" else "N m"


@dataclass(frozen=True, kw_only=True)
class Actuator:
    """A motor or a servo: on a hinge or slide, or a thruster, a tendon's winch or the like."""

    name: str
    """Its name in the description."""
    joint: str | None
    """The hinge or slide that it drives; None of one that drives none alone."""
    kind: str
    """`motor` (command is an effort) or `position` (command is a position)."""
    limit: float | None = None
    """Greatest effort, at the joint if it drives one, N m or N; None if none is given."""
    part: str = ""
    """What it acts on if not on a hinge or slide, such as `site propeller`."""
    effort_unit: str = "N m"
    """The unit of its effort."""


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """What the description measures."""

    name: str
    """Its name."""
    kind: str
    """MuJoCo's name of its kind, such as `gyro`."""
    part: str
    """The joint, site or body that it measures."""


@dataclass(frozen=True, kw_only=True)
class ClosedChain:
    """A closed chain: two links that a constraint holds together."""

    name: str
    """Its name."""
    kind: str
    """`connect` (a pin) or `weld`."""
    links: tuple[str, str]
    """The two links."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Robot:
    """One body as its description and its card state it."""

    name: str
    """What it is called."""
    links: tuple[Link, ...]
    """Every link but the world."""
    joints: tuple[Joint, ...]
    """Every joint."""
    actuators: tuple[Actuator, ...]
    """Every actuator."""
    mjcf: str
    """The description as MJCF text with explicit inertias; spec.py alone reads it."""
    assets: Mapping[str, bytes] = field(default_factory=dict)
    """Mesh and texture files that the MJCF names, by name."""
    source: Path | None = None
    """The description's file."""
    sha256: str = ""
    """Hash of the description and its card."""
    card: Card | None = None
    """What the shelf knows about it."""
    sensors: tuple[Sensor, ...] = ()
    """Every sensor."""
    loops: tuple[ClosedChain, ...] = ()
    """Every closed chain."""
    findings: tuple[DescriptionFinding, ...] = ()
    """What the importer found in the description."""
    posture: Mapping[str, float] | None = None
    """Where tasks on a floor start, as simulations are told; None for its own posture."""

    def __repr__(self) -> str:
        counts = f"{len(self.links)} links, {len(self.joints)} joints"
        return f"Robot({self.name}: {counts}, {len(self.actuators)} actuators, {self.mass:.4g} kg)"

    def joint(self, name: str) -> Joint:
        """Return a joint by its name.

        Raises:
            RobotError: There is no such joint.
        """
        return _named(self.joints, name, "joint", self.name)

    def actuator(self, name: str) -> Actuator:
        """Return an actuator by its name.

        Raises:
            RobotError: There is no such actuator.
        """
        return _named(self.actuators, name, "actuator", self.name)

    def link(self, name: str) -> Link:
        """Return a link by its name.

        Raises:
            RobotError: There is no such link.
        """
        return _named(self.links, name, "link", self.name)

    @property
    def driven(self) -> tuple[str, ...]:
        """The hinges and slides that actuators drive, in the actuators' order, each once."""
        return tuple(dict.fromkeys(each.joint for each in self.actuators if each.joint))

    def driven_by(self, actuator: Actuator) -> Joint:
        """Return the hinge or slide that an actuator drives.

        Raises:
            RobotError: It drives none.
        """
        if actuator.joint is None:
            raise RobotError(
                f"actuator {actuator.name!r} acts on {actuator.part}, and this needs actuators of "
                "hinges and slides",
                where=f"robot {self.name}",
                fix="give a body of which every actuator drives a hinge or slide",
            )
        return self.joint(actuator.joint)

    @property
    def mass(self) -> float:
        """The mass of all links, kg."""
        return sum(link.mass for link in self.links)


def _named(parts: tuple[Part, ...], name: str, kind: str, robot: str) -> Part:
    for part in parts:
        if part.name == name:
            return part
    known = ", ".join(part.name for part in parts) or "none"
    raise RobotError(
        f"there is no {kind} {name!r}; there are {known}",
        where=f"robot {robot}",
        fix=f"name one of these {kind}s",
    )
