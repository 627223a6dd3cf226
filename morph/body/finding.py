"""What the importer found in a description: named, placed, and how to put it right."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

Severity = Literal["info", "repaired", "refused"]
"""`info`: nothing was changed; `repaired`: the robot differs from the file; `refused`: no robot."""


@dataclass(frozen=True, kw_only=True)
class Where:
    """The place of a finding."""

    kind: str
    """`link`, `joint`, `mesh`, `actuator`, `sensor`, `file` or `robot`."""
    name: str
    """The name of what is concerned."""
    file: str = ""
    """The file that says so."""
    line: int = 0
    """The line in it, from 1; 0 if the file has no lines."""

    def __str__(self) -> str:
        at = f" ({self.file}:{self.line})" if self.line else f" ({self.file})" if self.file else ""
        return f"{self.kind} {self.name}{at}"


@dataclass(frozen=True, kw_only=True)
class DescriptionFinding:
    """One thing about a description that its author would want to know."""

    code: str
    """Its name, a key of `CODES`."""
    severity: Severity
    """What it means for the robot."""
    where: Where
    """What it concerns."""
    what: str
    """What was found, with the values."""
    done: str = "nothing"
    """What was done about it."""
    fix: str
    """How to put it right at the source."""

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise ValueError(f"{self.code!r} is no code of a finding")

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON holds it."""
        return asdict(self)


CODES: dict[str, str] = {
    # The tree of links and joints.
    "duplicate-name": "Two links or joints bear one name.",
    "dangling-joint": "A joint names a link that is not there, or none.",
    "cyclic-tree": "Links hang from each other in a circle, or one hangs from two parents.",
    "lost-base": "Links are joined to no base: the description falls into several trees.",
    "base-assumed": "Neither card nor flag says whether the base is bolted or floats.",
    "joint-kind": "A joint is of a kind that nobody knows, or that was put together from others.",
    "joint-axis": "A joint's axis has no direction, or no unit length.",
    "mimic": "A joint follows another that is not there, or itself.",
    "ill-typed": "An attribute is no number where numbers are due.",
    "unknown-element": "An element is doubled, misspelt or of another program, and was left out.",
    # Inertia.
    "mass-missing": "A link with a shape, or one that moves, has no mass.",
    "inertia-missing": "A link has mass and no rotational inertia.",
    "inertia-broken": "An inertia is not positive definite, or breaks the triangle inequality.",
    "inertia-swapped": "An inertia fits the link's shape only with its axes exchanged.",
    "inertia-oversized": "A mass is spread wider than the link's shape is.",
    "inertia-undersized": "A mass is packed far tighter than the link's shape is.",
    "mass-volume": "A mass does not fit the volume of the link's shape.",
    "mass-asymmetric": "A left and a right part differ in mass or inertia.",
    # Limits.
    "limit-absurd": "A limit is not finite, or reaches further than a joint can.",
    "limit-range": "A joint's range is empty: its lower limit is not below its upper one.",
    "limit-zero": "A joint's effort or velocity limit is zero or negative.",
    "reduction": "A transmission's reduction is not used: efforts and limits are the joint's.",
    # Shapes.
    "mesh-missing": "A mesh file is not there.",
    "mesh-case": "A mesh file is there under a name with other capitals.",
    "mesh-path": "A mesh file was found in another place than its path says.",
    "mesh-outside": "A path leads out of the description's folder.",
    "mesh-lfs-stub": "A mesh file is a Git-LFS stub: its content was never fetched.",
    "mesh-unreadable": "A mesh file is damaged, or of a kind that nobody reads.",
    "mesh-empty": "A mesh file has no faces, or no extent.",
    "mesh-too-large": "A mesh file is larger than any part is.",
    "mesh-inside-out": "A mesh's faces look inward: its volume is negative.",
    "mesh-open": "A mesh is not closed, so that its volume is a guess.",
    "mesh-concave": "A collision mesh is far from convex, and touches as its hull.",
    "mesh-units": "A mesh is a thousand times larger or smaller than its robot.",
    "length-units": "A link stands a thousand times further away than its neighbours.",
    "mesh-moved": "A mesh lies away from the mass of its link, or from its other shapes.",
    "shape-size": "A box, cylinder or sphere has no size.",
    # Symmetry and pose.
    "axis-flipped": "A joint turns the other way than its twin on the other side.",
    "limb-mirrored": "A limb stands on the side of its twin.",
    "self-collision": "Two parts overlap in the home pose.",
    "keyframe-range": "A keyframe puts a joint beyond its range.",
    # The files themselves.
    "file-refused": "A file cannot be read, or holds what no description may.",
    "engine-refused": "MuJoCo cannot use what was read.",
    "engine-warning": "MuJoCo warns of something in what was read.",
    "unsupported": "A part of the description that morph does not model was left out.",
    "agreement": "MuJoCo and Pinocchio disagree about the robot, or Pinocchio cannot read it or is "
    "not installed.",
}
"""Every code, with what it says."""
