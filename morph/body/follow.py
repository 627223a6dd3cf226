"""Which joints of a compiled model follow others."""

from __future__ import annotations

from typing import Any

import mujoco

from morph.body.robot import Mimic


def followers(model: Any) -> tuple[dict[int, Mimic], list[str]]:
    """Return each joint that follows another in proportion, and the names of those tied otherwise.

    MuJoCo ties the way y from home of one joint to the way x of another as
    y = a0 + a1 x + a2 x^2 + ...; here `offset` is a0 and `ratio` a1.
    Source: MuJoCo documentation, XML reference, equality/joint.
    """
    found: dict[int, Mimic] = {}
    others = []
    for index in range(model.neq):
        kind = mujoco.mjtEq(model.eq_type[index])
        if kind != mujoco.mjtEq.mjEQ_JOINT or not model.eq_active0[index]:
            continue
        first, second = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
        offset, ratio, *higher = model.eq_data[index, :5].tolist()
        if second < 0 or any(higher):
            others.append(model.joint(first).name)
        else:
            found[first] = Mimic(joint=model.joint(second).name, ratio=ratio, offset=offset)
    return found, others


def from_zero(model: Any, joint: int, mimic: Mimic) -> Mimic:
    """Return how a joint follows, its and the other's position counted from zero, not from home."""
    other = model.joint(mimic.joint).id
    here, there = (float(model.qpos0[model.jnt_qposadr[each]]) for each in (joint, other))
    offset = mimic.offset + here - mimic.ratio * there
    return Mimic(joint=mimic.joint, ratio=mimic.ratio, offset=offset)
