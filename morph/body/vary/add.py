"""Putting a new link on a body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np

from morph.body.draft import Shape
from morph.body.solids import solid
from morph.body.vary.keys import keeping_keys
from morph.body.vary.operation import Operation
from morph.body.vary.part import link, links

WORLD = "world"
"""The parent of a link that stands by itself."""

JOINTS = {"hinge": mujoco.mjtJoint.mjJNT_HINGE, "slide": mujoco.mjtJoint.mjJNT_SLIDE}
SIZES = {"box": 3, "sphere": 1, "cylinder": 2, "capsule": 2}
"""How many sizes each shape takes."""

GEOMS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
}


@dataclass(frozen=True, kw_only=True)
class Add(Operation):
    """A link more: a uniform solid that hangs on another by a joint, or fast.

    Its inertia is that of the solid (solids.py) about its centre of mass. The
    joint's axis runs through the origin of the link's frame. What is not said
    here is zero, whatever the description's own defaults are.
    """

    name: ClassVar[str] = "add"

    link: str
    """The new link's name."""
    parent: str
    """The link that carries it, or `world`."""
    mass: float
    """Mass, kg."""
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Origin of its frame in the parent's, m."""
    quaternion: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0)
    """Its frame in the parent's: w, x, y, z."""
    shape: str = "sphere"
    """`box`, `sphere`, `cylinder` or `capsule`; the last two lie along z."""
    size: tuple[float, ...] = (0.05,)
    """box: three edges; sphere: radius; cylinder and capsule: radius, length; m."""
    centre: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Centre of the solid in the link's frame, m."""
    joint: str = ""
    """The joint's name; empty: the link is fixed to its parent."""
    kind: str = "hinge"
    """The joint's kind: `hinge` or `slide`."""
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    """The joint's axis in the link's frame."""
    limits: tuple[float, ...] = ()
    """The joint's range, rad or m; empty: it moves freely."""
    damping: float = 0.0
    """The joint's damping, N m s/rad or N s/m."""
    armature: float = 0.0
    """Inertia of the joint's rotor, kg m2 or kg."""
    motor: float = 0.0
    """Greatest effort of a motor on the joint, N m or N; 0: it has none."""

    def __post_init__(self) -> None:
        self.check_positive("mass")
        for field in ("position", "centre", "axis"):
            self.check_length(field, 3)
        self.check_length("quaternion", 4)
        self.check_length("limits", 0, 2)
        numbers = ("position", "centre", "axis", "quaternion", "limits", "size")
        self.check_finite(*numbers, "damping", "armature", "motor")
        if self.shape not in SIZES:
            raise self.refuse(f"shape is {self.shape!r}", f"choose one of {', '.join(SIZES)}")
        self.check_length("size", SIZES[self.shape])
        if min(self.size) <= 0 or not any(self.quaternion):
            raise self.refuse("it has no extent or no direction", "give sizes above 0")
        if self.kind not in JOINTS:
            raise self.refuse(f"kind is {self.kind!r}", f"choose one of {', '.join(JOINTS)}")
        if self.joint and not any(self.axis):
            raise self.refuse("its axis has no direction", "give axis, such as 0, 0, 1")
        if self.limits and self.limits[0] >= self.limits[1]:
            raise self.refuse(f"its limits are {self.limits}", "give the lower limit first")
        if min(self.damping, self.armature, self.motor) < 0 or (self.motor and not self.joint):
            raise self.refuse(
                "damping, armature and motor are of a joint, and at least 0",
                "name the joint, and give numbers of 0 or more",
            )

    def apply(self, spec: Any) -> None:
        """Add the link, its joint and its motor."""
        taken = {
            "link": [body.name for body in links(spec)],
            "joint": [joint.name for joint in spec.joints],
            "motor": [actuator.name for actuator in spec.actuators],
        }
        wanted = {"link": self.link, "joint": self.joint, "motor": self.joint if self.motor else ""}
        for kind, name in wanted.items():
            if (name and name in taken[kind]) or wanted["link"] in ("", WORLD):
                raise self.refuse(f"the {kind} {name!r} is there already", f"rename the {kind}")
        parent = spec.worldbody if self.parent == WORLD else link(spec, self.parent)
        with keeping_keys(spec):
            body = self._body(parent)
            if self.joint:
                self._joint(body)
            if self.motor:
                self._motor(spec)

    def _body(self, parent: Any) -> Any:
        turn = np.array(self.quaternion) / np.linalg.norm(self.quaternion)
        body = parent.add_body(name=self.link, pos=self.position, quat=turn)
        body.mass, body.ipos, body.explicitinertial = self.mass, self.centre, True
        unit = solid(Shape(role="collision", kind=self.shape, size=self.size))
        if unit is None:
            raise self.refuse(f"its size {self.size} has no volume", "give it larger sizes")
        body.inertia = np.diag(unit.inertia) * self.mass / unit.volume
        half = {1: self.size, 2: (self.size[0], self.size[-1] / 2)}
        size = half.get(len(self.size), tuple(edge / 2 for edge in self.size))
        geom = body.add_geom(type=GEOMS[self.shape], pos=self.centre)
        geom.size = (*size, 0.0, 0.0)[:3]
        return body

    def _joint(self, body: Any) -> None:
        joint = body.add_joint(name=self.joint, type=JOINTS[self.kind], axis=self.axis)
        limited = mujoco.mjtLimited
        joint.pos, joint.ref, joint.springref = np.zeros(3), 0.0, 0.0
        joint.limited = limited.mjLIMITED_TRUE if self.limits else limited.mjLIMITED_FALSE
        joint.range = self.limits or (0.0, 0.0)
        joint.stiffness, joint.damping = np.zeros(3), (self.damping, 0.0, 0.0)
        joint.armature, joint.frictionloss = self.armature, 0.0
        joint.actfrclimited = limited.mjLIMITED_FALSE

    def _motor(self, spec: Any) -> None:
        motor = spec.add_actuator(name=self.joint, target=self.joint)
        limited = mujoco.mjtLimited
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.set_to_motor()
        motor.gear = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        motor.ctrllimited, motor.ctrlrange = limited.mjLIMITED_TRUE, (-self.motor, self.motor)
        motor.forcelimited, motor.actlimited = limited.mjLIMITED_FALSE, limited.mjLIMITED_FALSE
