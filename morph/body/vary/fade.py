"""A part that only one of two bodies has, as it grows or shrinks.

A link of presence w, from 0 (absent) to 1 (whole), is that link at the scale
s = s0 + (1 - s0) w: lengths s, mass s^3, inertia s^5 (scale.py). What drives
and holds its joint is scaled so that it moves like the whole one, with time
passing as sqrt(s): under gravity efforts m g l go as s^4, dampers as s^4.5 and
rotor inertias as s^5.

Its joint is locked by a constraint of impedance d = 1 - w that pulls back to
the home position r0 within a time T = T1 w / (1 - w): with a the acceleration
that the joint would have without it,

    r'' + 2 r' / T + (r - r0) / T^2 = w a

(MuJoCo documentation, Computation, Solver parameters: a1 + d (b v + k r) =
(1 - d) a0, with b = 2 / (d T) and k = 1 / (d T)^2). At w = 0 the joint stands
still to MuJoCo's least softness; at w = 1 there is no constraint. MuJoCo's
constraint is as soft as the joint moves lightly by itself, and absent links in
a row move most lightly against each other. So the joint also gets a rotor
inertia of m l^2 (1 - w)^3, with m the mass of the robot and l = 0.1 m: where
the joint stands still it has no effect, and where it does not it has gone.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.body.vary.affine import Affine, stretch_shape
from morph.body.vary.blend import copy_inertia, straight, turned

SMALLEST = 0.03
"""s0: its mass is 3e-5 and its inertia 2e-8 of the whole link's."""

LEAST = 1e-12
"""Inertia that an absent link keeps about every axis, kg m2: MuJoCo refuses 1e-15."""

LEVER = 0.1
"""l: m, the size of a limb."""

RELEASE = 0.1
"""T1: s, a time in which bodies of a metre hardly move."""

STIFFEST = 1e-4
"""Least T, s; MuJoCo raises it to two timesteps."""

HARDEST = 0.9999
"""MuJoCo's greatest impedance (mjMAXIMP)."""

IDENTITY = (1.0, 0.0, 0.0, 0.0)

MOVING = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
JOINT_FIELDS = {
    "type": 0.0, "axis": 0.0, "pos": 1.0, "range": 0.0, "limited": 0.0, "ref": 0.0,
    "springref": 0.0, "stiffness": 4.0, "damping": 4.5, "armature": 5.0, "frictionloss": 4.0,
    "margin": 0.0, "actfrclimited": 0.0, "actfrcrange": 4.0, "solref_limit": 0.0,
    "solimp_limit": 0.0,
}  # fmt: skip
"""What makes a hinge, with the power of s by which it goes."""
ACTUATOR_FIELDS = (
    "trntype", "gaintype", "biastype", "dyntype", "ctrlspec", "gear", "ctrllimited", "ctrlrange",
    "forcelimited", "actlimited", "actrange", "actdim", "dynprm",
)  # fmt: skip
EFFORTS = ("forcerange", "gainprm", "biasprm")
"""What makes an actuator, and what of it is an effort."""
GEOM_FIELDS = (
    "type", "pos", "quat", "size", "contype", "conaffinity", "condim", "priority", "friction",
    "solmix", "solref", "solimp", "margin", "gap", "rgba", "group", "fluid_ellipsoid",
    "fluid_coefs",
)  # fmt: skip


def size_at(presence: float, smallest: float) -> float:
    """Return s, the scale of a link of a presence w: s0 + (1 - s0) w."""
    return smallest + (1 - smallest) * presence


def fade_body(spec: Any, body: Any, source: Any, presence: float, s: float) -> None:
    """Give a body the inertia and the shapes of another at the scale s."""
    copy_inertia(body, source)
    if body.explicitinertial:
        body.mass, body.ipos = body.mass * s**3, body.ipos * s
        body.inertia = body.inertia * s**5 + LEAST * (1 - presence)
    body.gravcomp = source.gravcomp
    if not body.geoms:
        _draw(body, source)
    by = Affine(S=s * np.eye(3), c=np.zeros(3))
    for shape in (*body.geoms, *body.sites):
        stretch_shape(spec, shape, by)
    if presence == 0.0:
        for geom in body.geoms:
            geom.contype = geom.conaffinity = 0


def place_between(body: Any, source: Any, presence: float) -> None:
    """Set the pose of a link that carries links of both: at w = 0 it takes no room."""
    body.pos = straight(np.zeros(3), source.pos, presence)
    body.quat = turned(IDENTITY, source.quat, presence)


def fade_joint(joint: Any, source: Any, s: float) -> None:
    """Give a joint the numbers of another at the scale s."""
    slide = source.type == mujoco.mjtJoint.mjJNT_SLIDE
    for field, power in JOINT_FIELDS.items():
        setattr(joint, field, _scaled(getattr(source, field), s**power))
    if slide:
        # Its positions are lengths: per length, forces go as s^3, dampers as s^2.5.
        for field in ("range", "ref", "springref"):
            setattr(joint, field, _scaled(getattr(source, field), s))
        for field, power in (("stiffness", 2.0), ("damping", 2.5), ("armature", 3.0),
                             ("frictionloss", 3.0), ("actfrcrange", 3.0)):  # fmt: skip
            setattr(joint, field, _scaled(getattr(source, field), s**power))


def fade_actuator(actuator: Any, source: Any, effort: float) -> None:
    """Give an actuator the law of another, with its efforts times a factor."""
    for field in ACTUATOR_FIELDS:
        setattr(actuator, field, getattr(source, field))
    for field in EFFORTS:
        setattr(actuator, field, getattr(source, field) * effort)
    if effort == 0.0:
        actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_FALSE


def effort_at(s: float, *, slide: bool) -> float:
    """Return by what efforts at a joint go with a size s: torques s^4, forces s^3."""
    return s**3 if slide else s**4


def lock_by_constraint(spec: Any, joint: Any, presence: float, mass: float) -> None:
    """Lock a hinge or slide, the less the more of it is there; not at all where it is whole.

    Args:
        spec: The body between.
        joint: The joint.
        presence: w, 0 to 1.
        mass: m: of the robot, kg.
    """
    if presence < 1.0:
        square = 1.0 if joint.type == mujoco.mjtJoint.mjJNT_SLIDE else LEVER**2
        joint.armature = joint.armature + mass * square * (1 - presence) ** 3
        lock = spec.add_equality(
            name=f"fading {joint.name}", type=mujoco.mjtEq.mjEQ_JOINT, name1=joint.name
        )
        lock.objtype = mujoco.mjtObj.mjOBJ_JOINT
        lock.data = np.zeros(len(lock.data))
        _soften(lock, presence)


def weld_by_constraint(spec: Any, joint: Any, presence: float, mass: float) -> None:
    """Lock a free or ball joint in the same way: its link is welded to what carries it, at home."""
    if presence < 1.0:
        body = joint.parent
        joint.armature = joint.armature + mass * (1 - presence) ** 3
        weld = spec.add_equality(
            name=f"fading {joint.name}",
            type=mujoco.mjtEq.mjEQ_WELD,
            name1=body.name,
            name2=body.parent.name,
        )
        weld.objtype = mujoco.mjtObj.mjOBJ_BODY
        # Anchor and relative pose are zero: MuJoCo takes them as they stand at home.
        weld.data = (*np.zeros(10), 1.0, *np.zeros(len(weld.data) - 11))
        _soften(weld, presence)


def _soften(lock: Any, presence: float) -> None:
    T = max(RELEASE * presence / (1 - presence), STIFFEST)
    d = min(max(1 - presence, 1 - HARDEST), HARDEST)
    lock.active, lock.solref, lock.solimp = True, (T, 1.0), (d, d, 0.001, 0.5, 2.0)


def _draw(body: Any, source: Any) -> None:
    # Meshes and materials belong to the other body's files: they come with the nearer half.
    for geom in source.geoms:
        if geom.type != mujoco.mjtGeom.mjGEOM_MESH:
            copy = body.add_geom()
            for field in GEOM_FIELDS:
                setattr(copy, field, getattr(geom, field))


def _scaled(value: Any, factor: float) -> Any:
    return value if factor == 1.0 else value * factor
