"""The same body with the opposite sign for what some of its joints count as positive."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.body.vary.fade import MOVING
from morph.errors import RobotError


def opposite(first: Any, second: Any) -> list[str]:
    """Return the hinges and slides of both specs whose axes point more than 90 degrees apart."""
    results = []
    for joint in second.joints:
        twin = first.joint(joint.name)
        if twin and joint.type in MOVING and twin.axis @ joint.axis < 0:
            results.append(str(joint.name))
    return results


def reverse(spec: Any, name: str) -> None:
    """Describe a hinge or slide with the opposite axis: q' = -q, and its commands u' = -u.

    Keyframes go.

    A law F = g u + b0 + b1 q + b2 v gives F' = -F = g u' - b0 + b1 q' + b2 v'.

    Raises:
        RobotError: A tendon runs over the joint, or a law is not of this kind.
    """
    joint = spec.joint(name)
    joint.axis = -joint.axis
    joint.range = _reversed(joint.range)
    joint.actfrcrange = _reversed(joint.actfrcrange)
    joint.ref, joint.springref = -joint.ref, -joint.springref
    for actuator in spec.actuators:
        if actuator.target == name:
            _reverse_actuator(actuator)
    for tie in spec.equalities:
        if tie.type == mujoco.mjtEq.mjEQ_JOINT and name in (tie.name1, tie.name2):
            _reverse_tie(tie, name)
    for tendon in spec.tendons:
        for wrap in tendon.path:
            if wrap.type == mujoco.mjtWrap.mjWRAP_JOINT and wrap.target.name == name:
                raise _refused(name, f"the tendon {tendon.name!r} runs over it")
    for key in list(spec.keys):
        spec.delete(key)


def _reverse_actuator(actuator: Any) -> None:
    bias = (mujoco.mjtBias.mjBIAS_NONE, mujoco.mjtBias.mjBIAS_AFFINE)
    if actuator.biastype not in bias or actuator.gaintype != mujoco.mjtGain.mjGAIN_FIXED:
        raise _refused(actuator.target, f"the law of {actuator.name!r} has a direction")
    actuator.ctrlrange = _reversed(actuator.ctrlrange)
    actuator.forcerange = _reversed(actuator.forcerange)
    actuator.actrange = _reversed(actuator.actrange)
    actuator.biasprm = (-actuator.biasprm[0], *actuator.biasprm[1:])


def _reverse_tie(tie: Any, name: str) -> None:
    # q1 = c0 + c1 q2 + c2 q2^2 + ...: MuJoCo documentation, XML Reference, equality/joint.
    data = np.array(tie.data)
    if name == tie.name1:
        data[:5] *= -1
    if name == tie.name2:
        data[1:5:2] *= -1
    tie.data = data


def _reversed(limits: Any) -> tuple[float, float]:
    return -float(limits[1]), -float(limits[0])


def _refused(name: str, what: str) -> RobotError:
    return RobotError(
        f"its axis is opposite in the two bodies, and it cannot be turned: {what}",
        where=f"joint {name!r}",
        fix="turn the axis in one description, or give a mapping that leaves its link unmatched",
    )
