"""Four-bars and other closed chains, which URDF cannot hold."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.card import Closure
from morph.body.four_bar import FourBar as FourBar
from morph.errors import RobotError

KINDS = ("four-bar", "planar", "ball")
"""The kinds of closed chain that a card may name."""

APART = 1e-4
"""How far apart the two ends of a pin may be at home, m: a tenth of what is printed."""

SKEW = 1e-6
"""How far from parallel the axes of a planar chain may be, rad."""

STIFF = ((0.004, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2.0))
"""Time constant and impedance of a pin (MuJoCo's solref and solimp).

0.004 s is two timesteps of 2 ms, the stiffest that is stable; 0.9999 is MuJoCo's
greatest impedance.
"""


def loop_residual(axes: Array, anchors: Array, angles: Array, pin: Array) -> Array:
    """Return by how far a closed chain of hinges fails to close, m, shape (3,).

    The chain is cut at its pin and followed from one side of the cut to the other. At home
    it closes; turned by `angles`, it carries the pin to exp(S1 q1) ... exp(Sn qn) p, which
    should be p. Source: Lynch and Park 2017, Modern Robotics, eq. 4.14 and section 7.1.

    Args:
        axes: Each hinge's axis at home, towards which its angle is positive; a joint that is
            followed from child to parent counts with its axis reversed. Shape (n, 3).
        anchors: A point on each axis at home, m, shape (n, 3).
        angles: Each hinge's angle from home, rad, shape (n,).
        pin: The pin at home, m, shape (3,).
    """
    point = np.asarray(pin, float)
    for axis, anchor, angle in zip(axes[::-1], anchors[::-1], angles[::-1], strict=True):
        unit, arm = axis / np.linalg.norm(axis), point - anchor
        along = unit * (unit @ arm)
        point = anchor + along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(unit, arm)
    return np.asarray(point - pin)


def close_chain(spec: Any, closure: Closure, where: str) -> str:
    """Return the name of the pin that it adds to a `mujoco.MjSpec`, as a `connect` equality.

    The description holds the open tree; the pin joins the last of the closure's links to the
    first. Where it is: the card's `pin`, in the frame of the last link; or else the one place
    where a site or a fixed frame of the last link meets one of the first.

    Raises:
        RobotError: The kind or a link is unknown, the pin cannot be found, its ends are more
            than `APART` apart at home, or the chain is not planar though its kind is.
    """
    if closure.kind not in KINDS or len(closure.bodies) < 2:
        raise RobotError(
            f"a closure of kind {closure.kind!r} with {len(closure.bodies)} links is not known",
            where=where,
            fix=f"name two links or more, and one of the kinds {', '.join(KINDS)}",
        )
    model = _compiled(spec, where)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    chain = [_body(model, name, where) for name in closure.bodies]
    _check_loop(model, data, closure, chain, where)
    pin = _pin(model, data, closure, (chain[-1], chain[0]), where)
    first, last = closure.bodies[0], closure.bodies[-1]
    added = spec.add_equality(
        name=f"{last}_to_{first}",
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=last,
        name2=first,
    )
    added.data[:3] = pin
    added.solref, added.solimp = STIFF
    return str(added.name)


def _compiled(spec: Any, where: str) -> Any:
    try:
        return spec.copy().compile()
    except ValueError as error:
        raise RobotError(
            f"the open tree does not compile: {error}",
            where=where,
            fix="correct the element that MuJoCo names",
        ) from error


def _body(model: Any, name: str, where: str) -> int:
    result = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
    if result < 0:
        known = ", ".join(model.body(index).name for index in range(1, model.nbody))
        raise RobotError(
            f"the closure names a link {name!r}; there are {known}",
            where=where,
            fix="correct the bodies of the [[closure]]",
        )
    return int(result)


def _ancestry(model: Any, body: int) -> list[int]:
    results = [body]
    while results[-1] != 0:
        results.append(int(model.body_parentid[results[-1]]))
    return results


def _check_loop(model: Any, data: Any, closure: Closure, chain: list[int], where: str) -> None:
    last, first = _ancestry(model, chain[-1]), _ancestry(model, chain[0])
    moving = set(last) ^ set(first)
    joints = [index for index in range(model.njnt) if model.jnt_bodyid[index] in moving]
    outside = set(chain) - moving - {next(body for body in last if body in first)}
    if outside or (closure.kind == "four-bar" and len(joints) != 3):
        listed = ", ".join(model.joint(index).name for index in joints) or "none"
        raise RobotError(
            f"the loop of {', '.join(closure.bodies)} has the joints {listed}, not those of a "
            f"{closure.kind}",
            where=where,
            fix="name the links of one loop in order; a four-bar has three hinges and the pin",
        )
    if closure.kind == "ball":
        return
    for index in joints:
        hinge = model.jnt_type[index] == mujoco.mjtJoint.mjJNT_HINGE
        skew = np.linalg.norm(np.cross(data.xaxis[joints[0]], data.xaxis[index]))
        if not hinge or skew > SKEW:
            raise RobotError(
                f"is not planar: the joint {model.joint(index).name!r} is not a hinge parallel "
                f"to {model.joint(joints[0]).name!r}",
                where=where,
                fix="make the loop's axes parallel, or give the closure the kind ball",
            )


def _pin(model: Any, data: Any, closure: Closure, ends: tuple[int, int], where: str) -> Array:
    last, first = ends
    for point in (closure.pin, closure.pin_on_first):
        if len(point) not in (0, 3):
            raise RobotError(
                f"a pin has three coordinates, not {len(point)}", where=where, fix="give x, y and z"
            )
    if closure.pin_on_first and not closure.pin:
        world = data.xpos[first] + _frame(data, first) @ np.array(closure.pin_on_first)
        return np.asarray(_frame(data, last).T @ (world - data.xpos[last]))
    if not closure.pin:
        return _meeting(model, data, closure, ends, where)
    pin = np.array(closure.pin)
    if closure.pin_on_first:
        gap = data.xpos[last] + _frame(data, last) @ pin - data.xpos[first]
        gap = gap - _frame(data, first) @ np.array(closure.pin_on_first)
        _check_gap(float(np.linalg.norm(gap)), closure, where)
    return pin


def _check_gap(gap: float, closure: Closure, where: str) -> None:
    if gap > APART:
        raise RobotError(
            f"at home the ends of the pin of {closure.bodies[-1]!r} and {closure.bodies[0]!r} are "
            f"{gap * 1e3:.4g} mm apart; at most {APART * 1e3:.4g} mm",
            where=where,
            fix="correct pin and pin_on_first, or the joints' origins, so that the loop closes",
        )


def _meeting(model: Any, data: Any, closure: Closure, ends: tuple[int, int], where: str) -> Array:
    last, first = (_points(model, data, body) for body in ends)
    gaps = sorted(
        (float(np.linalg.norm(one - other)), tuple(one)) for one in last for other in first
    )
    if not gaps:
        raise RobotError(
            f"neither a site nor a fixed frame says where {closure.bodies[-1]!r} and "
            f"{closure.bodies[0]!r} meet",
            where=where,
            fix="give the [[closure]] a pin, a point in the frame of its last link",
        )
    _check_gap(gaps[0][0], closure, where)
    return np.asarray(_frame(data, ends[0]).T @ (np.array(gaps[0][1]) - data.xpos[ends[0]]))


def _points(model: Any, data: Any, body: int) -> list[Array]:
    # What URDF calls a frame is a link on a fixed joint: here a body without a joint.
    pose = _frame(data, body)
    sites = [model.site_pos[i] for i in range(model.nsite) if model.site_bodyid[i] == body]
    results = [data.xpos[body] + pose @ site for site in sites]
    for child in range(1, model.nbody):
        if model.body_parentid[child] == body and model.body_jntnum[child] == 0:
            results += [data.xpos[child].copy(), *_points(model, data, child)]
    return results


def _frame(data: Any, body: int) -> Array:
    return np.asarray(data.xmat[body].reshape(3, 3))
