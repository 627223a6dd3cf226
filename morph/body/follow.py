"""Which joints of a compiled model follow others."""

from __future__ import annotations

from typing import Any

import mujoco

from morph.arrays import Array
from morph.body.robot import Mimic

RIGID, QUICK = (0.9999, 0.9999, 0.001, 0.5, 2.0), (0.005, 1.0)
"""`solimp` and `solref` of joints tied as rigidly as MuJoCo can: by default a tenth of the
needed force is left out. Source: MuJoCo documentation, Modeling, solver parameters."""


def followers(model: Any) -> tuple[dict[int, Mimic], list[str]]:
    """Return each joint that follows another in proportion, and the names of those tied otherwise.

    MuJoCo ties the way y from home of one joint to the way x of another as
    y = a0 + a1 x + a2 x^2 + ...; here `offset` is a0 and `ratio` a1.
    Source: MuJoCo documentation, XML reference, equality/joint.
    """
    results: dict[int, Mimic] = {}
    others = []
    for index in range(model.neq):
        kind = mujoco.mjtEq(model.eq_type[index])
        if kind != mujoco.mjtEq.mjEQ_JOINT or not model.eq_active0[index]:
            continue
        first, second = int(model.eq_obj1id[index]), int(model.eq_obj2id[index])
        offset, ratio, *higher = model.eq_data[index, :5].tolist()
        if second < 0 or any(higher) or first in results:
            others.append(model.joint(first).name)
        else:
            results[first] = Mimic(joint=model.joint(second).name, ratio=ratio, offset=offset)
    return results, others


def leaders(model: Any) -> dict[int, tuple[int, float, float]]:
    """Return each follower's leader that follows none, and its ratio and offset from zero.

    By the joints' indices; see `Mimic`. Joints that follow each other in a ring are left out.
    """
    direct = {
        joint: (model.joint(mimic.joint).id, from_zero(model, joint, mimic))
        for joint, mimic in followers(model)[0].items()
    }
    results = {}
    for joint, (leader, mimic) in direct.items():
        ratio, offset, passed = mimic.ratio, mimic.offset, {joint}
        while leader in direct and leader not in passed:
            passed.add(leader)
            leader, above = direct[leader]
            ratio, offset = ratio * above.ratio, ratio * above.offset + offset
        if leader not in passed:
            results[joint] = leader, ratio, offset
    return results


def chains(model: Any) -> list[int]:
    """Return the constraints that hold two points together, by their indices."""
    pinned = model.eq_type == mujoco.mjtEq.mjEQ_CONNECT
    return [int(at) for at in (pinned & (model.eq_active0 != 0)).nonzero()[0]]


def follow(model: Any, position: Array, velocity: Array) -> None:
    """Place joints that follow others where these put them, (samples, nq) and (samples, nv)."""
    for joint, (leader, ratio, offset) in leaders(model).items():
        place, at = model.jnt_qposadr[[joint, leader]]
        position[:, place] = ratio * position[:, at] + offset
        rate, speed = model.jnt_dofadr[[joint, leader]]
        velocity[:, rate] = ratio * velocity[:, speed]


def from_zero(model: Any, joint: int, mimic: Mimic) -> Mimic:
    """Return how a joint follows, its and the other's position counted from zero, not from home."""
    other = model.joint(mimic.joint).id
    here, there = (float(model.qpos0[model.jnt_qposadr[each]]) for each in (joint, other))
    offset = mimic.offset + here - mimic.ratio * there
    return Mimic(joint=mimic.joint, ratio=mimic.ratio, offset=offset)
