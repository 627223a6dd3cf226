"""Chains that swing in gravity: how they hang, how they stand upright, and where they end."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from morph.body.robot import Joint, Robot
from morph.body.spec import spec_of
from morph.errors import TaskError
from morph.sim.integrator import Integrator, is_smooth

LONG, SHORT = 0.01, 0.002
"""Steps of chains that move freely, and of others, s."""

MANY = 3
"""Hinges from which on the links at the end of a chain are fast enough for half that step."""

Signs = tuple[float, ...]
"""1 or -1 for each of several hinges."""

HORIZONTAL = 0.1
"""Greatest vertical part of the axis of a hinge that swings in gravity."""


def hinges_of(robot: Robot, task: str) -> tuple[Joint, ...]:
    """Return the hinges of a body that swings in gravity, from its root on.

    Raises:
        TaskError: It has none, it floats, or it is driven by nothing.
    """
    hinges = tuple(joint for joint in robot.joints if joint.kind == "hinge")
    if not hinges or any(joint.kind in {"free", "ball"} for joint in robot.joints):
        raise TaskError(
            "it has no hinge to swing about" if not hinges else "it is not held to the world",
            where=f"task {task} of {robot.name}",
            fix="give a chain of hinges on a fixed base or a slide, such as cartpole",
        )
    return hinges


def stepping(robot: Robot) -> tuple[float, Integrator]:
    """Return the step, s, and the integrator that move a chain rightly.

    Under random commands at their bounds RK4 at 0.01 s keeps a cart-pole within 1e-4 rad of its
    limit over 3 s, where implicitfast is 0.1 rad off at 0.005 s and takes as long.
    """
    hinges = sum(joint.kind == "hinge" for joint in robot.joints)
    step = LONG if hinges <= MANY else LONG / 2
    if is_smooth(spec_of(robot, timestep=step).compile()):
        return step, "rk4"
    return SHORT, "implicitfast"


def slides_of(robot: Robot, *, driven: bool) -> tuple[Joint, ...]:
    """Return the slides of a body, or those alone that an actuator drives."""
    actuated = set(robot.driven)
    return tuple(
        joint
        for joint in robot.joints
        if joint.kind == "slide" and (joint.name in actuated or not driven)
    )


def posture(robot: Robot, task: str, *, upright: bool) -> dict[str, float]:
    """Return the angle of each hinge, rad, at which its link is highest or lowest.

    From the root on, each link is turned until its centre of mass stands right above its
    hinge, or hangs right below it; so a chain is stretched, and rests where nothing acts.

    Raises:
        TaskError: The body has no hinge that gravity swings, or it is held by limits elsewhere.
    """
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    results: dict[str, float] = {}
    for joint in hinges_of(robot, task):
        here = model.joint(joint.name)
        mujoco.mj_kinematics(model, data)
        if abs(data.xaxis[here.id][2]) > HORIZONTAL:
            continue
        # Turned about a horizontal axis, a height is a + b cos angle + c sin angle.
        heights = []
        for angle in (0.0, math.pi / 2, math.pi):
            data.qpos[here.qposadr[0]] = angle
            mujoco.mj_kinematics(model, data)
            heights.append(float(data.xipos[here.bodyid[0], 2]))
        middle = (heights[0] + heights[2]) / 2
        b, c = heights[0] - middle, heights[1] - middle
        highest, lowest = _tidy(math.atan2(c, b)), _tidy(math.atan2(-c, -b))
        # What cannot be held up, such as the arms of a rider, hangs.
        wanted = (highest, lowest) if upright else (lowest,)
        reached = [each for each in wanted if _within(joint, each)]
        if not reached:
            raise _out_of_reach(joint, wanted[0], robot, task)
        results[joint.name] = data.qpos[here.qposadr[0]] = reached[0]
    if not results:
        raise TaskError(
            "gravity swings none of its hinges",
            where=f"task {task} of {robot.name}",
            fix="give a body with a hinge whose axis is horizontal",
        )
    return results


def _tidy(angle: float) -> float:
    """Return an angle, rad; rounding must not tell -pi from pi, nor zero from nearly zero."""
    if abs(angle) < 1e-6:
        return 0.0
    return math.pi if math.isclose(abs(angle), math.pi, abs_tol=1e-6) else angle


def _within(joint: Joint, angle: float) -> bool:
    low, high = joint.limits or (-math.inf, math.inf)
    return any(low - 1e-6 <= angle + turn <= high + 1e-6 for turn in (-math.tau, 0.0, math.tau))


def _out_of_reach(joint: Joint, angle: float, robot: Robot, task: str) -> TaskError:
    low, high = joint.limits or (-math.inf, math.inf)
    return TaskError(
        f"joint {joint.name!r} would have to stand at {angle:.3g} rad, "
        f"and its range is {low:.3g} to {high:.3g}",
        where=f"task {task} of {robot.name}",
        fix="give a body that can reach this posture, or another task",
    )


def ways(robot: Robot, angles: dict[str, float]) -> dict[str, tuple[tuple[str, ...], Signs]]:
    """Return for each hinge the hinges on the way to its link, and how each of them turns.

    A sign is 1 if a hinge turns as the first on the way does, and -1 if the other way round: so
    the signed sum of the angles says how the link stands, wherever it branches off.
    """
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    for name, angle in angles.items():
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_kinematics(model, data)
    results = {}
    for hinge in angles:
        body = int(model.joint(hinge).bodyid[0])
        way: list[str] = []
        while body:
            first = int(model.body_jntadr[body])
            here = [model.joint(first + at).name for at in range(int(model.body_jntnum[body]))]
            way = [name for name in here if name in angles] + way
            body = int(model.body_parentid[body])
        axes = [data.xaxis[model.joint(name).id] for name in way]
        signs = tuple(1.0 if float(axis @ axes[0]) >= 0.0 else -1.0 for axis in axes)
        results[hinge] = (tuple(way), signs)
    return results


def end_of(robot: Robot) -> tuple[str, tuple[float, float, float]]:
    """Return the last link of a chain and its end, m, as if it were a uniform rod."""
    parents = {link.parent for link in robot.links}
    moved = {joint.link for joint in robot.joints}
    last = [link for link in robot.links if link.name not in parents and link.name in moved]
    link = last[-1] if last else robot.link(robot.joints[-1].link)
    x, y, z = (2.0 * along for along in link.com)
    return link.name, (x, y, z)


def place_of(robot: Robot, angles: dict[str, float], link: str) -> tuple[np.ndarray, float]:
    """Return where the end of a link is in a posture, and how far it is from its first hinge, m."""
    model: Any = spec_of(robot).compile()
    data = mujoco.MjData(model)
    for name, angle in angles.items():
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_kinematics(model, data)
    _, offset = end_of(robot)
    body = model.body(link).id
    end = data.xpos[body] + data.xmat[body].reshape(3, 3) @ np.array(offset)
    root = data.xanchor[model.joint(next(iter(angles))).id]
    return end, float(np.linalg.norm(end - root))
