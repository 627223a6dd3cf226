"""The numbers of a part that two bodies have, on the way from one to the other."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from morph.arrays import Array
from morph.body.vary.pseudo import between, pseudo_inertia, set_pseudo_inertia

JOINT_NUMBERS = (
    "pos", "ref", "springref", "stiffness", "damping", "armature", "frictionloss", "margin",
    "solref_limit", "solimp_limit", "solref_friction", "solimp_friction",
)  # fmt: skip
ACTUATOR_NUMBERS = ("gear", "gainprm", "biasprm", "dynprm")
JOINT_LIMITS = {"range": "limited", "actfrcrange": "actfrclimited"}
ACTUATOR_LIMITS = {
    "ctrlrange": "ctrllimited",
    "forcerange": "forcelimited",
    "actrange": "actlimited",
}
"""Ranges, each with the field that says whether it holds."""
SHAPE_NUMBERS = ("pos", "size")
OPTION_NUMBERS = ("gravity", "wind", "magnetic", "density", "viscosity")


def straight(first: ArrayLike, second: ArrayLike, fraction: float) -> Any:
    """Return numbers in a straight line from the first to the second, exact at both ends."""
    one, other = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    # Not through arithmetic where both are equal: infinity and NaN come through unhurt.
    mixed = np.where(one == other, one, (1 - fraction) * one + fraction * other)
    result = one if fraction == 0.0 else other if fraction == 1.0 else mixed
    return result.copy() if result.ndim else float(result)


def turned(first: ArrayLike, second: ArrayLike, fraction: float) -> Array:
    """Return a unit quaternion on the shortest turn from the first to the second.

    Source: Shoemake 1985, SIGGRAPH 19(3), slerp.
    """
    one, other = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if fraction in (0.0, 1.0) or (one == other).all():
        return (other if fraction == 1.0 else one).copy()
    one, other = one / np.linalg.norm(one), other / np.linalg.norm(other)
    return _arc(one, other if one @ other >= 0 else -other, fraction)


def blend_body(body: Any, first: Any, second: Any, fraction: float) -> None:
    """Set a body's pose in its parent and its inertia."""
    body.pos = straight(first.pos, second.pos, fraction)
    body.quat = turned(first.quat, second.quat, fraction)
    body.gravcomp = straight(first.gravcomp, second.gravcomp, fraction)
    ends = [each for each in (first, second) if each.explicitinertial]
    if fraction in (0.0, 1.0) or len(ends) < 2 or _same_inertia(first, second):
        copy_inertia(body, (first, second)[round(fraction)])
    else:
        J = between(pseudo_inertia(first), pseudo_inertia(second), fraction)
        set_pseudo_inertia(body, J)


def copy_inertia(body: Any, source: Any) -> None:
    """Give a body another one's inertia, to the last bit."""
    body.explicitinertial = source.explicitinertial
    if source.explicitinertial:
        body.mass, body.ipos, body.iquat = source.mass, source.ipos.copy(), source.iquat.copy()
        body.inertia = source.inertia.copy()


def blend_joint(joint: Any, first: Any, second: Any, fraction: float) -> None:
    """Set a joint's numbers."""
    if joint.type != mujoco.mjtJoint.mjJNT_FREE:
        joint.axis = _direction(first.axis, second.axis, fraction)
    for field in JOINT_NUMBERS:
        ends = getattr(first, field), getattr(second, field)
        setattr(joint, field, straight(*ends, fraction))
    blend_limits(joint, first, second, fraction, JOINT_LIMITS)


def blend_actuator(actuator: Any, first: Any, second: Any, fraction: float) -> None:
    """Set an actuator's numbers, if both are of one law; else the nearer body's stay."""
    laws = ("gaintype", "biastype", "dyntype", "trntype")
    if all(getattr(first, law) == getattr(second, law) for law in laws):
        for field in ACTUATOR_NUMBERS:
            ends = getattr(first, field), getattr(second, field)
            setattr(actuator, field, straight(*ends, fraction))
        blend_limits(actuator, first, second, fraction, ACTUATOR_LIMITS)


def blend_limits(
    part: Any, first: Any, second: Any, fraction: float, limits: dict[str, str]
) -> None:
    """Set ranges; one that only one end has is c + (range - c) / presence: at 0, none.

    c is where the joint stands at home, and zero for efforts and commands.
    """
    for field, flag in limits.items():
        ends = [getattr(each, field) for each in (first, second)]
        holds = [_holds(each, field, flag) for each in (first, second)]
        value = straight(ends[0], ends[1], fraction)
        presence = (1 - fraction) * holds[0] + fraction * holds[1]
        if any(holds) and not all(holds):
            centre = part.ref if field == "range" else 0.0
            value = np.zeros(2)
            if presence > 0:
                value = centre + (ends[holds.index(True)] - centre) / presence
        yes, no = mujoco.mjtLimited.mjLIMITED_TRUE, mujoco.mjtLimited.mjLIMITED_FALSE
        setattr(part, flag, yes if presence > 0 else no)
        setattr(part, field, value)


def _holds(part: Any, field: str, flag: str) -> bool:
    limited = mujoco.mjtLimited(int(getattr(part, flag)))
    if limited == mujoco.mjtLimited.mjLIMITED_AUTO:
        return bool(np.any(getattr(part, field)))
    return bool(limited == mujoco.mjtLimited.mjLIMITED_TRUE)


def blend_shapes(body: Any, first: Any, second: Any, fraction: float) -> None:
    """Set the poses and sizes of shapes and sites that both have; the others stay as they are.

    Shapes are paired by kind, in order; sites by name. Meshes stay.
    """
    for kind in {int(geom.type) for geom in body.geoms} - {int(mujoco.mjtGeom.mjGEOM_MESH)}:
        rows = [[g for g in each.geoms if int(g.type) == kind] for each in (body, first, second)]
        for geom, one, other in zip(*rows, strict=False):
            _blend_shape(geom, one, other, fraction)
    for site in body.sites:
        one, other = (_site(each, site.name) for each in (first, second))
        if one and other:
            _blend_shape(site, one, other, fraction)


def blend_options(spec: Any, first: Any, second: Any, fraction: float) -> None:
    """Set gravity and the medium."""
    for field in OPTION_NUMBERS:
        ends = getattr(first.option, field), getattr(second.option, field)
        setattr(spec.option, field, straight(*ends, fraction))


def _site(body: Any, name: str) -> Any:
    return next((site for site in body.sites if site.name == name and name), None)


def _blend_shape(shape: Any, first: Any, second: Any, fraction: float) -> None:
    shape.quat = turned(first.quat, second.quat, fraction)
    for field in SHAPE_NUMBERS:
        setattr(shape, field, straight(getattr(first, field), getattr(second, field), fraction))


def _same_inertia(first: Any, second: Any) -> bool:
    fields = ("mass", "ipos", "iquat", "inertia")
    return all(np.array_equal(getattr(first, each), getattr(second, each)) for each in fields)


def _direction(first: ArrayLike, second: ArrayLike, fraction: float) -> Array:
    one, other = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    if fraction in (0.0, 1.0) or (one == other).all():
        return (other if fraction == 1.0 else one).copy()
    one, other = one / np.linalg.norm(one), other / np.linalg.norm(other)
    return _arc(one, other, fraction)


def _arc(one: Array, other: Array, fraction: float) -> Array:
    angle = np.arctan2(np.linalg.norm(one - other), np.linalg.norm(one + other)) * 2
    if angle < 1e-9:
        return one.copy()
    mixed: Array = np.sin((1 - fraction) * angle) * one + np.sin(fraction * angle) * other
    return mixed / np.linalg.norm(mixed)
