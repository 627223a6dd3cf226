"""Making a link, or the whole body, larger or smaller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.vary.affine import Affine, stretch_shape
from morph.body.vary.keys import scale_keys
from morph.body.vary.lock import matrix
from morph.body.vary.operation import Operation
from morph.body.vary.part import WHOLE, anchor, link, links
from morph.body.vary.pseudo import pseudo_inertia, set_pseudo_inertia

SLIDE, FREE = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_FREE
CONNECT, WELD = mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD


@dataclass(frozen=True, kw_only=True)
class Scale(Operation):
    """A link of another size: every point x goes to c + S (x - c).

    c is the link's joint, which stays where it is; S = s 1, or with an axis a
    (a unit vector) S = 1 + (s - 1) a a^T. The links that it carries move along
    with the place they hang on and keep their own size. Its pseudo-inertia J
    (pseudo.py) goes to rho T J T^T, with T = diag(S, 1) about c. Density stays
    by default: rho = det S, so that with S = s 1 mass grows as s^3 and inertia
    as s^5. With `mass = "keep"`, rho = 1: inertia grows as s^2.

    Shapes, sites, cameras and the travel of the link's own slides scale with
    it. Motors, springs, dampers, friction and armature stay. A loop that a
    constraint closes stays closed at home: its anchor goes along with the
    link, and the other link takes hold of it there. A pin between two sites
    moves with the sites: if they part, the constraint pulls them together.

    `*` scales every link about the world's origin, where the body stands.
    """

    name: ClassVar[str] = "scale"
    amount: ClassVar[str] = "factor"

    link: str
    """The link, or `*` for the whole body."""
    factor: float
    """s: length per length before."""
    along: tuple[float, ...] = ()
    """a: the only direction to stretch in, in the link's frame; empty for all directions."""
    mass: str = "density"
    """What stays: `density`, or `keep` for the mass."""

    def __post_init__(self) -> None:
        self.check_positive("factor")
        self.check_length("along", 0, 3)
        self.check_finite("along")
        if self.along and not max(map(abs, self.along)) > 1e-12:
            raise self.refuse("along has no direction", "give along three numbers, such as 0, 0, 1")
        if self.along and self.link == WHOLE:
            raise self.refuse("links point in many directions", "stretch one link at a time")
        if self.mass not in ("density", "keep"):
            raise self.refuse(f"mass is {self.mass!r}", "set mass to 'density' or 'keep'")

    def apply(self, spec: Any) -> None:
        """Scale the link or all links."""
        whole = self.link == WHOLE
        chosen = links(spec) if whole else [link(spec, self.link)]
        if self.factor == 1.0:
            return
        lengths: dict[str, float] = {}
        for body in chosen:
            by = Affine(S=self._stretch(), c=np.zeros(3) if whole else anchor(body))
            self._scale_mass(body, by)
            lengths |= _scale_joints(body, by, whole)
            for part in (*body.geoms, *body.sites):
                stretch_shape(spec, part, by)
            for part in (*body.cameras, *body.lights):
                part.pos = by.point(part.pos)
            if whole:
                body.pos = by.point(body.pos)
            else:
                _carry(body, by)
        _scale_loops(spec, chosen, by, whole)
        scale_keys(spec, lengths)
        _scale_servos(spec, lengths)

    def _stretch(self) -> Array:
        if not self.along:
            return self.factor * np.eye(3)
        axis = np.array(self.along) / np.linalg.norm(self.along)
        return np.eye(3) + (self.factor - 1) * np.outer(axis, axis)

    def _scale_mass(self, body: Any, by: Affine) -> None:
        if not body.explicitinertial:
            return
        denser = 1.0 if self.mass == "keep" else float(np.linalg.det(by.S))
        if by.uniform:
            denser = 1.0 if self.mass == "keep" else self.factor**3
            body.mass = body.mass * denser
            body.inertia = body.inertia * (denser * self.factor**2)
            body.ipos = by.point(body.ipos)
            return
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = by.S, by.c - by.S @ by.c
        set_pseudo_inertia(body, denser * T @ pseudo_inertia(body) @ T.T)


def _scale_joints(body: Any, by: Affine, whole: bool) -> dict[str, float]:
    lengths: dict[str, float] = {}
    for joint in body.joints:
        if joint.type == FREE:
            if whole:
                lengths[joint.name] = float(by.S[0, 0])
            continue
        joint.pos = by.point(joint.pos)
        if joint.type == SLIDE:
            factor = lengths[joint.name] = by.along(joint.axis)
            joint.range = joint.range * factor
            joint.ref, joint.springref = joint.ref * factor, joint.springref * factor
    return lengths


def _carry(body: Any, by: Affine) -> None:
    # A child is held at its joint, which need not be the origin of its frame.
    for child in body.bodies:
        held = child.pos + matrix(child.quat) @ anchor(child)
        child.pos = child.pos + by.point(held) - held


def _scale_loops(spec: Any, chosen: list[Any], by: Affine, whole: bool) -> None:
    names = {body.name for body in chosen}
    for loop in spec.equalities:
        if loop.type not in (CONNECT, WELD) or loop.objtype != mujoco.mjtObj.mjOBJ_BODY:
            continue
        data = np.array(loop.data)
        # A connect gives its anchor in the first body's frame, a weld in the second's.
        holder = loop.name1 if loop.type == CONNECT else loop.name2
        if holder in names:
            data[:3] = by.point(data[:3])
        if loop.type == WELD and whole:
            data[3:6] *= by.S[0, 0]
        elif loop.type == WELD and names & {loop.name1, loop.name2}:
            data[3:10] = 0.0  # MuJoCo then takes the relative pose at home.
        loop.data = data


def _scale_servos(spec: Any, lengths: dict[str, float]) -> None:
    # A position servo's commands are positions of its joint.
    for actuator in spec.actuators:
        servo = actuator.biastype == mujoco.mjtBias.mjBIAS_AFFINE and actuator.biasprm[1] != 0
        if servo and actuator.target in lengths:
            actuator.ctrlrange = actuator.ctrlrange * lengths[actuator.target]
