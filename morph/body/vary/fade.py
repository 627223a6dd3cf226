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
still to MuJoCo's least softness; at w = 1 there is no constraint.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.body.vary.affine import Affine, stretch_shape
from morph.body.vary.blend import copy_inertia, straight, turned
from morph.errors import RobotError

SMALLEST = 0.03
"""s0: its mass is 3e-5 and its inertia 2e-8 of the whole link's, far above MuJoCo's least."""

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
ACTUATOR_FIELDS = {
    "trntype": 0.0, "gaintype": 0.0, "biastype": 0.0, "dyntype": 0.0, "ctrlspec": 0.0, "gear": 0.0,
    "ctrllimited": 0.0, "ctrlrange": 0.0, "forcelimited": 0.0, "forcerange": 4.0, "actlimited": 0.0,
    "actrange": 0.0, "actdim": 0.0, "dynprm": 0.0, "gainprm": 4.0, "biasprm": 4.0,
}  # fmt: skip
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
        body.inertia = body.inertia * s**5
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
    """Give a joint the numbers of another at the scale s.

    Raises:
        RobotError: It is no hinge or slide, so that no such lock holds it.
    """
    if source.type not in MOVING:
        raise RobotError(
            "one body has a free or ball joint there, and the other does not",
            where=f"joint {source.name!r}",
            fix="lock that joint first, or give both bodies one",
        )
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


def fade_actuator(actuator: Any, source: Any, slide: bool, s: float) -> None:
    """Give an actuator the law of another, with the efforts of the scale s."""
    for field, power in ACTUATOR_FIELDS.items():
        # On a slide efforts are forces, which go as s^3.
        factor = s ** (power - 1 if slide and power else power)
        setattr(actuator, field, _scaled(getattr(source, field), factor))


def lock_by_constraint(spec: Any, joint: str, presence: float) -> None:
    """Lock a joint, the less the more of it is there; not at all where it is whole."""
    if presence == 1.0:
        return
    T = max(RELEASE * presence / (1 - presence), STIFFEST)
    d = min(max(1 - presence, 1 - HARDEST), HARDEST)
    lock = spec.add_equality(name=f"fading {joint}", type=mujoco.mjtEq.mjEQ_JOINT, name1=joint)
    lock.objtype = mujoco.mjtObj.mjOBJ_JOINT
    lock.active, lock.data = True, np.zeros(len(lock.data))
    lock.solref, lock.solimp = (T, 1.0), (d, d, 0.001, 0.5, 2.0)


def _draw(body: Any, source: Any) -> None:
    # Meshes and materials belong to the other body's files: they come with the nearer half.
    for geom in source.geoms:
        if geom.type != mujoco.mjtGeom.mjGEOM_MESH:
            copy = body.add_geom()
            for field in GEOM_FIELDS:
                setattr(copy, field, getattr(geom, field))


def _scaled(value: Any, factor: float) -> Any:
    return value if factor == 1.0 else value * factor
