"""Where a simulation starts: joints by their names, floating bodies by their channels."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from morph.arrays import Array
from morph.body.robot import Joint, Robot
from morph.errors import RobotError
from morph.nearest import nearest
from morph.record.quantities import WXYZ, XYZ

PLACES = tuple(f"position.{axis}" for axis in XYZ) + tuple(f"orientation.{axis}" for axis in WXYZ)
"""What the start of a floating body is told by, in the order of MuJoCo's `qpos`."""

SPEEDS = tuple(f"{which}_velocity.{axis}" for which in ("linear", "angular") for axis in XYZ)
"""What its speed is told by, in the order of MuJoCo's `qvel`."""


PARTS: Mapping[str, Callable[[Joint], str]] = {
    "free": lambda joint: joint.link,
    "ball": lambda joint: joint.name,
}
"""What the channels of a joint that turns freely begin with."""
MOVES = {"free": "floats", "ball": "turns"}
"""What an error says of its link."""


def started(
    robot: Robot,
    model: Any,
    start: Mapping[str, float] | None = None,
    speed: Mapping[str, float] | None = None,
) -> tuple[Array, Array]:
    """Return the state that a simulation starts from: position (nq,) and velocity (nv,).

    Args:
        robot: The robot.
        model: Its `mujoco.MjModel`.
        start: By a hinge or slide its position, rad or m; by `hull.position.z` or
            `hull.orientation.w` that of a body that floats, m, and a quaternion that is
            brought to length 1: of one that is told in part the rest is 0; by
            `ball.orientation.w` that of a ball joint. All else is as the description has it.
        speed: Likewise, per s: by a joint, `hull.linear_velocity.x` (world frame) or
            `hull.angular_velocity.z` (the body's frame). All else is at rest.

    Raises:
        RobotError: A name is not the robot's, or an orientation is none.
    """
    position, velocity = model.qpos0.copy(), np.zeros(model.nv)
    turned: dict[str, list[int]] = {}
    for name, value in (start or {}).items():
        joint, slot = _found(robot, name, PLACES)
        address = int(model.joint(joint.name).qposadr[0])
        first = 3 if joint.kind == "free" else 0
        if joint.kind in PARTS and slot >= first and joint.link not in turned:
            turned[joint.link] = list(range(address + first, address + first + 4))
            position[turned[joint.link]] = 0.0
        position[address + slot] = value
    for name, value in (speed or {}).items():
        joint, slot = _found(robot, name, SPEEDS)
        velocity[int(model.joint(joint.name).dofadr[0]) + slot] = value
    for link, four in turned.items():
        length = float(np.linalg.norm(position[four]))
        if length == 0.0:
            raise RobotError(
                "its orientation is all zero, and a quaternion has a length",
                where=f"robot {robot.name}, start of {link}",
                fix=f"upright is {link}.orientation.w = 1 and the rest 0",
            )
        position[four] /= length
    return position, velocity


def _found(robot: Robot, name: str, known: tuple[str, ...]) -> tuple[Joint, int]:
    """Return the joint that a name means, and which of its numbers."""
    for joint in robot.joints:
        part = PARTS[joint.kind](joint) if joint.kind in PARTS else ""
        if part and name.startswith(f"{part}."):
            rest = name.removeprefix(f"{part}.")
            mine = known if joint.kind == "free" else known[3:]
            if rest in mine:
                return joint, mine.index(rest)
            raise RobotError(
                f"there is no {name!r}; of {part}, which {MOVES[joint.kind]}, there are "
                + ", ".join(mine),
                where=f"robot {robot.name}",
                fix=f"the nearest are {nearest(rest, mine)}",
            )
    joint = robot.joint(name)
    if joint.kind in {"hinge", "slide"}:
        return joint, 0
    part, first = PARTS[joint.kind](joint), 0 if joint.kind == "free" else 3
    fix = f"say {part}.{known[first]} and so on, up to {part}.{known[-1]}"
    raise RobotError(
        f"the {joint.kind} joint {name!r} has no single position or velocity",
        where=f"robot {robot.name}",
        fix=fix,
    )
