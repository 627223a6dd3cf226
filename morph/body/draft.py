"""A description as it was read, before it is checked and becomes a Robot."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from morph.arrays import Array

if TYPE_CHECKING:
    from morph.body.mesh import Mesh

MOVING = ("revolute", "continuous", "prismatic", "floating", "planar", "ball")
"""Kinds of joints that move; `fixed` is the one that does not."""


@dataclass(frozen=True, kw_only=True)
class Pose:
    """Where a frame stands in another."""

    position: Array = field(default_factory=lambda: np.zeros(3))
    """Its origin, m, shape (3,)."""
    rotation: Array = field(default_factory=lambda: np.eye(3))
    """Its axes as columns, shape (3, 3)."""

    def then(self, other: Pose) -> Pose:
        """Return the pose, in the outer frame, of a frame that is given in this one."""
        return Pose(
            position=self.position + self.rotation @ other.position,
            rotation=self.rotation @ other.rotation,
        )

    def apply(self, points: Array) -> Array:
        """Return points of this frame, shape (..., 3), in the outer one."""
        moved: Array = points @ self.rotation.T + self.position
        return moved


@dataclass(frozen=True, kw_only=True)
class Shape:
    """A visual or a collision shape of a link."""

    role: str
    """`visual` or `collision`."""
    kind: str
    """`mesh`, `box`, `sphere`, `cylinder` or `capsule`."""
    pose: Pose = field(default_factory=Pose)
    """In the link's frame."""
    size: tuple[float, ...] = ()
    """box: three full edges; sphere: radius; cylinder and capsule: radius, length along z; m."""
    file: str = ""
    """mesh: the file as the description writes it."""
    path: Path | None = None
    """mesh: the file found; None if there is none."""
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """mesh: metres per unit of the file, along each axis."""
    mesh: Mesh | None = None
    """mesh: its content, unscaled; None if it could not be read."""
    colour: tuple[float, float, float, float] | None = None
    """Red, green, blue, opacity, 0 to 1."""
    line: int = 0
    """Its line in the description."""


@dataclass(frozen=True, kw_only=True)
class DraftLink:
    """A link."""

    name: str
    """Its name."""
    mass: float | None = None
    """kg; None if the description gives none."""
    com: Array = field(default_factory=lambda: np.zeros(3))
    """Centre of mass in the link's frame, m, shape (3,)."""
    inertia: Array | None = None
    """About the centre of mass, along the link's axes, kg m2, shape (3, 3); None if not given."""
    inertia_from: str = "description"
    """`measured`, `description`, `mesh x density` or `none`."""
    shapes: tuple[Shape, ...] = ()
    """Visual and collision shapes."""
    line: int = 0
    """Its line in the description."""


@dataclass(frozen=True, kw_only=True)
class DraftMimic:
    """A joint that follows another: position = ratio * other + offset."""

    joint: str
    """The joint that it follows."""
    ratio: float = 1.0
    """Movement per movement of the other."""
    offset: float = 0.0
    """Position where the other is at zero, rad or m."""


@dataclass(frozen=True, kw_only=True)
class DraftJoint:
    """A joint."""

    name: str
    """Its name."""
    kind: str
    """`fixed`, or one of `MOVING`."""
    parent: str
    """The link that carries it."""
    child: str
    """The link that it moves."""
    pose: Pose = field(default_factory=Pose)
    """Frame of the child in that of the parent, at position zero."""
    axis: Array = field(default_factory=lambda: np.array((1.0, 0.0, 0.0)))
    """In the child's frame, shape (3,)."""
    lower: float | None = None
    """Least position, rad or m; None if there is none."""
    upper: float | None = None
    """Greatest position, rad or m; None if there is none."""
    effort: float | None = None
    """Greatest effort, N m or N; None if not given."""
    velocity: float | None = None
    """Greatest speed, rad/s or m/s; None if not given."""
    damping: float = 0.0
    """N m s/rad or N s/m."""
    friction: float = 0.0
    """N m or N."""
    mimic: DraftMimic | None = None
    """Set if it follows another joint."""
    line: int = 0
    """Its line in the description."""


@dataclass(frozen=True, kw_only=True)
class Draft:
    """A body as its description states it, right or wrong."""

    name: str
    """What it calls itself."""
    file: Path
    """The description's file."""
    links: tuple[DraftLink, ...]
    """In the file's order."""
    joints: tuple[DraftJoint, ...] = ()
    """In the file's order."""

    def link(self, name: str) -> DraftLink:
        """Return the first link of a name; KeyError if there is none."""
        for link in self.links:
            if link.name == name:
                return link
        raise KeyError(name)

    def with_links(self, changed: dict[str, DraftLink]) -> Draft:
        """Return the draft with some links exchanged, by name."""
        return replace(self, links=tuple(changed.get(link.name, link) for link in self.links))

    def with_joints(self, changed: dict[str, DraftJoint]) -> Draft:
        """Return the draft with some joints exchanged, by name."""
        return replace(self, joints=tuple(changed.get(joint.name, joint) for joint in self.joints))

    def joint_above(self) -> dict[str, DraftJoint]:
        """Return, for each link that a joint moves, that joint."""
        return {joint.child: joint for joint in self.joints}

    def heads(self) -> dict[str, str]:
        """Return, for each link, the topmost of those that fixed joints weld to it."""
        above = self.joint_above()
        results: dict[str, str] = {}
        for link in self.links:
            name = link.name
            while name in above and above[name].kind == "fixed":
                name = above[name].parent
            results[link.name] = name
        return results

    def roots(self) -> tuple[str, ...]:
        """Return the links that no joint moves, in order."""
        children = {joint.child for joint in self.joints}
        return tuple(link.name for link in self.links if link.name not in children)

    def home(self) -> dict[str, Pose]:
        """Return the pose of each link in the frame of its root, all joints at zero.

        The draft must be a forest: `check/tree.py` has seen to that.
        """
        above = self.joint_above()
        poses: dict[str, Pose] = {}
        for link in self.links:
            chain = []
            name = link.name
            while name not in poses and name in above:
                chain.append(name)
                name = above[name].parent
            poses.setdefault(name, Pose())
            for each in reversed(chain):
                poses[each] = poses[above[each].parent].then(above[each].pose)
        return poses
