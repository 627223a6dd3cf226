"""What the actuators of a compiled description act on, and how strong they are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.robot import Actuator
from morph.errors import RobotError

JOINTED = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
PARTS = {
    mujoco.mjtTrn.mjTRN_TENDON: mujoco.mjtObj.mjOBJ_TENDON,
    mujoco.mjtTrn.mjTRN_SITE: mujoco.mjtObj.mjOBJ_SITE,
    mujoco.mjtTrn.mjTRN_SLIDERCRANK: mujoco.mjtObj.mjOBJ_SITE,
    mujoco.mjtTrn.mjTRN_BODY: mujoco.mjtObj.mjOBJ_BODY,
}
"""What actuators act on that drive no joint."""


def actuator_of(model: Any, index: int, source: Path) -> Actuator:
    """Return an actuator of a compiled `mujoco.MjModel`.

    Raises:
        RobotError: It turns an orientation by three forces.
    """
    joint = driven_joint(model, index)
    kind, at = mujoco.mjtTrn(model.actuator_trntype[index]), int(model.actuator_trnid[index, 0])
    if kind == mujoco.mjtTrn.mjTRN_SO3:
        raise RobotError(
            f"the actuator {model.actuator(index).name!r} turns an orientation by three forces",
            where=str(source),
            fix="give it a joint, a site, a tendon or a body",
        )
    part, force = "", True
    if joint is not None:
        force = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
    else:
        named = PARTS.get(kind, mujoco.mjtObj.mjOBJ_JOINT)
        word = mujoco.mjtObj(named).name.removeprefix("mjOBJ_").lower()
        part = f"{word} {mujoco.mj_id2name(model, named, at)}"
        if kind != mujoco.mjtTrn.mjTRN_TENDON:
            force = bool(model.actuator_gear[index, :3].any())
    return Actuator(
        name=model.actuator(index).name,
        joint=None if joint is None else model.joint(joint).name,
        kind="position" if _is_servo(model, index) else "motor",
        limit=_limit(model, index, joint),
        part=part,
        effort_unit="N" if force else "N m",
    )


def driven_joint(model: Any, actuator: int) -> int | None:
    """Return the number of the hinge or slide that an actuator drives; None if it drives none."""
    # A number of numpy's is in no tuple of MuJoCo's names: it must be one itself.
    if mujoco.mjtTrn(model.actuator_trntype[actuator]) not in JOINTED:
        return None
    joint = int(model.actuator_trnid[actuator, 0])
    return joint if mujoco.mjtJoint(model.jnt_type[joint]) in SCALAR else None


def strength(model: Any, actuator: int) -> float:
    """Return what an actuator gives by its own force; see `leverage`."""
    return leverage(model.actuator_gear[actuator], model.actuator_trntype[actuator])


def leverage(gear: Array, transmission: int) -> float:
    """Return the size of a gear, of a thruster's that of its force or, without one, of its torque.

    It is 1 where that is zero.
    """
    wrench = gear[:3] if gear[:3].any() else gear[3:]
    at_site = mujoco.mjtTrn(transmission) == mujoco.mjtTrn.mjTRN_SITE
    return float(np.linalg.norm(wrench if at_site else gear[:1])) or 1.0


def _limit(model: Any, index: int, joint: int | None) -> float | None:
    gear = strength(model, index)
    gain = float(model.actuator_gainprm[index, 0])
    limits = []
    if model.actuator_forcelimited[index]:
        limits.append(gear * float(np.abs(model.actuator_forcerange[index]).max()))
    if model.actuator_ctrllimited[index] and not _is_servo(model, index):
        limits.append(gear * abs(gain) * float(np.abs(model.actuator_ctrlrange[index]).max()))
    if joint is not None and model.jnt_actfrclimited[joint]:
        limits.append(float(np.abs(model.jnt_actfrcrange[joint]).max()))
    return min(limits, default=None)


def _is_servo(model: Any, index: int) -> bool:
    # The inputs that an actuator takes are bits; none set means it does not say.
    says = int(model.actuator_ctrlspec[index])
    if says:
        return bool(says & int(mujoco.mjtCtrlInput.mjINPUT_POS))
    # One that pulls back in proportion to the joint's position is a servo.
    affine = model.actuator_biastype[index] == mujoco.mjtBias.mjBIAS_AFFINE
    return bool(affine and model.actuator_biasprm[index, 1] != 0)
