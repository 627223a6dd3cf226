"""Taking out of a description whatever refers to a joint that goes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mujoco

JOINT, TENDON, ACTUATOR = (
    mujoco.mjtObj.mjOBJ_JOINT,
    mujoco.mjtObj.mjOBJ_TENDON,
    mujoco.mjtObj.mjOBJ_ACTUATOR,
)
TRANSMISSIONS = {
    JOINT: (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT),
    TENDON: (mujoco.mjtTrn.mjTRN_TENDON,),
    ACTUATOR: (),
}
"""The ways in which an actuator can hang on a part."""
EQUALITIES = {
    JOINT: mujoco.mjtEq.mjEQ_JOINT,
    TENDON: mujoco.mjtEq.mjEQ_TENDON,
    ACTUATOR: None,
}
"""The constraint that ties parts of a kind."""


def unhook(spec: Any, kind: Any, name: str) -> None:
    """Delete all that refers to a joint, a tendon or an actuator, but not the part itself.

    MuJoCo deletes what refers to a body that goes, but not what refers to a joint.
    """
    if kind == JOINT:
        for tendon in list(spec.tendons):
            if any(_is_joint(wrap, name) for wrap in tendon.path):
                unhook(spec, TENDON, tendon.name)
                spec.delete(tendon)
    for actuator in list(spec.actuators):
        if actuator.target == name and actuator.trntype in TRANSMISSIONS[kind]:
            unhook(spec, ACTUATOR, actuator.name)
            spec.delete(actuator)
    for equality in list(spec.equalities):
        if equality.type == EQUALITIES[kind] and name in (equality.name1, equality.name2):
            spec.delete(equality)
    for sensor in list(spec.sensors):
        if (sensor.objtype, sensor.objname) == (kind, name):
            spec.delete(sensor)


def inventory(spec: Any) -> list[str]:
    """Return every named part that a change may remove, as a reader would call it."""
    families: tuple[tuple[str, Iterable[Any]], ...] = (
        ("link", spec.bodies[1:]),
        ("joint", spec.joints),
        ("actuator", spec.actuators),
        ("sensor", spec.sensors),
        ("tendon", spec.tendons),
        ("equality", spec.equalities),
        ("contact pair", spec.pairs),
        ("contact exclusion", spec.excludes),
        ("site", spec.sites),
    )
    return [f"{family} {_called(part)!r}" for family, parts in families for part in parts]


def _called(part: Any) -> str:
    if part.name:
        return str(part.name)
    ends = [getattr(part, field, "") for field in ("name1", "name2", "objname", "bodyname1")]
    return " ".join(end for end in ends if end)


def _is_joint(wrap: Any, name: str) -> bool:
    return bool(wrap.type == mujoco.mjtWrap.mjWRAP_JOINT and wrap.target.name == name)
