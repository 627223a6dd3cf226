"""Bodies on a skateboard: feet welded or in contact, wheels driven or free."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Literal
from xml.etree import ElementTree

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.fulltext import fulltext
from morph.body.load import load
from morph.body.robot import Robot
from morph.body.servo import DYNAMIXELS, Servo
from morph.body.spec import bare_spec
from morph.body.vary.apply import rebuilt
from morph.errors import RobotError
from morph.files import sha256

BOARD = "humanoid_skateboard"
"""The body of the shelf whose board is taken."""

DECK = 0.0055
"""Half the thickness of its deck, m."""

GAP = 1e-4
"""How far soles sink into the deck at first, m: about what a rider's weight presses them in."""

SOLE = 0.005
"""How much of a foot counts as its sole, from its lowest point up, m."""

DRIVE = 40.0
"""Greatest force of the motor that drives a board, N: that of the planar riders."""

MARK = "rider."
"""What the names of the rider begin with while two descriptions become one."""

Board = Literal["driven", "passive", "free"]
"""Pushed along a rail by a motor, rolling along one, or rolling on its wheels on the floor."""


def on_board(robot: Robot, feet: tuple[str, str], *, board: Board, ahead: float = 0.0) -> Robot:
    """Return a floating body that stands on a skateboard with flat feet, facing along it.

    Where the board is free, soles and deck meet by contact alone. Else the feet are welded to the
    deck, and nothing touches. Each sole is a box: what its foot's shapes span just above their
    lowest point. Motors become the position servos of their strength, `servo_for`.

    Args:
        robot: A body that floats by one free joint, standing upright as it is described.
        feet: Its left and its right foot, links.
        board: How it rolls.
        ahead: How far in front of the deck's middle the middle of the feet stands, m.

    Raises:
        RobotError: It does not float, or has no such foot.
    """
    free = [joint for joint in robot.joints if joint.kind == "free"]
    if len(free) != 1:
        raise RobotError(
            f"it has {len(free)} free joints",
            where=f"robot {robot.name} on a board",
            fix="give a body that floats by one free joint",
        )
    for foot in feet:
        robot.link(foot)
    rider, root = bare_spec(robot), free[0].link
    soles, turn = _soles(rider.compile(), feet)
    _bare(rider, soles, touching=board == "free")
    _servos(rider, robot)
    spec = _board(board)
    body = _attached(spec, rider, root)
    middle = turn @ np.mean([each[3] for each in soles.values()], axis=0)
    deck = np.array([ahead, 0.0, DECK - GAP])
    body.pos = deck - middle
    flat = np.zeros(4)
    mujoco.mju_mat2Quat(flat, turn.reshape(9))
    body.quat = flat
    if board != "free":
        for foot in feet:
            _weld(spec, foot)
    spec.compile()
    spec = mujoco.MjSpec.from_string(_unmarked(fulltext(spec)))
    digest = sha256(robot.sha256 or robot.mjcf, "on a board", board, *feet, repr(ahead))
    # Its meshes went with its shapes.
    bare = replace(robot, assets={})
    return rebuilt(spec, bare, f"{robot.name}+board({board})", digest)


def servo_for(effort: float) -> Servo:
    """Return the servo whose greatest torque is nearest an effort, N m, in proportion."""
    return min(DYNAMIXELS, key=lambda each: abs(np.log(each.limit / effort)))


def _soles(
    model: Any, feet: tuple[str, str]
) -> tuple[dict[str, tuple[Array, Array, Array, Array]], Array]:
    """Return the sole of each foot, and the turn by which the body faces along x.

    A sole is its half size, its centre and its frame in the foot, and its middle in the frame
    of the root. A foot reaches farther ahead of the ankle than behind it.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    result, away = {}, np.zeros(3)
    root = data.xpos[1]
    for foot in feet:
        body = model.body(foot).id
        points = _points(model, data, body)
        low = points[points[:, 2] < points[:, 2].min() + SOLE]
        least, most = low.min(axis=0), low.max(axis=0)
        half = 0.5 * (most - least)
        half[2] = 0.5 * SOLE
        least[2] = points[:, 2].min()
        centre = least + half
        frame = data.xmat[body].reshape(3, 3).T
        place = frame @ (centre - data.xpos[body])
        away += centre - data.xpos[body]
        result[foot] = (half, place, frame, np.append(centre[:2], least[2]) - root)
    across = int(np.argmin(np.abs(away[:2])))
    along = np.zeros(3)
    along[1 - across] = np.sign(away[1 - across])
    side = np.cross([0.0, 0.0, 1.0], along)
    return result, np.stack([along, side, [0.0, 0.0, 1.0]])


def _points(model: Any, data: Any, body: int) -> Array:
    """Return the corners of all shapes of a link, m, in the world."""
    results = []
    for geom in np.flatnonzero(model.geom_bodyid == body):
        mesh = int(model.geom_dataid[geom])
        if mesh >= 0:
            first = int(model.mesh_vertadr[mesh])
            corners = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])]
        else:
            signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
            corners = model.geom_aabb[geom, :3] + signs * model.geom_aabb[geom, 3:]
        turn = data.geom_xmat[geom].reshape(3, 3)
        results.append(corners @ turn.T + data.geom_xpos[geom])
    return np.concatenate(results)


def _bare(
    spec: Any, soles: dict[str, tuple[Array, Array, Array, Array]], *, touching: bool
) -> None:
    """Leave a body no shapes but its soles, and neither free joint nor keyframes."""
    for geom in list(spec.geoms):
        spec.delete(geom)
    for each in (*spec.meshes, *spec.materials, *spec.textures):
        spec.delete(each)
    for joint in list(spec.joints):
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            spec.delete(joint)
    for key in list(spec.keys):
        spec.delete(key)
    for foot, (half, place, frame, _) in soles.items():
        turn = np.zeros(4)
        mujoco.mju_mat2Quat(turn, np.ascontiguousarray(frame).reshape(9))
        spec.body(foot).add_geom(
            name=f"{foot}_sole",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=half,
            pos=place,
            quat=turn,
            contype=0,
            conaffinity=int(touching),
            group=1,
        )


def _servos(spec: Any, robot: Robot) -> None:
    """Turn motors into position servos, and give their joints a servo's armature."""
    for actuator in robot.actuators:
        if actuator.kind == "position":
            continue
        here = spec.actuator(actuator.name)
        joint = spec.joint(actuator.joint)
        servo = servo_for(actuator.limit or 1.0)
        here.set_to_position(kp=servo.kp, kv=servo.kv)
        here.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        here.forcelimited, here.forcerange = 1, [-servo.limit, servo.limit]
        here.ctrllimited, here.ctrlrange = 1, joint.range
        joint.armature = servo.armature


def _board(board: Board) -> Any:
    """Return the board alone as a spec; on a rail its wheels and trucks are held."""
    spec = bare_spec(load(BOARD))
    spec.delete(spec.body("pelvis"))
    for each in (*spec.actuators, *spec.keys):
        spec.delete(each)
    if board == "free":
        return spec
    for geom in list(spec.geoms):
        geom.contype = geom.conaffinity = 0
    wheels = [joint for joint in spec.joints if joint.name.endswith("wheel")]
    # What rolls without slipping turns: m r^2 / 2 of each wheel is m / 2 more along the rail.
    turning = sum(0.5 * float(spec.body(joint.name).mass) for joint in wheels)
    for joint in list(spec.joints):
        spec.delete(joint)
    spec.body("board").add_joint(
        name="board", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[1, 0, 0], armature=turning
    )
    if board == "driven":
        motor = spec.add_actuator(
            name="board", target="board", trntype=mujoco.mjtTrn.mjTRN_JOINT,
            ctrllimited=1, ctrlrange=[-DRIVE, DRIVE],
        )  # fmt: skip
        motor.set_to_motor()
    return spec


def _attached(spec: Any, rider: Any, root: str) -> Any:
    """Put a rider on the board, free over it by three slides and a ball."""
    frame = spec.body("board").add_frame()
    body = frame.attach_body(rider.body(root), MARK, "")
    for axis, name in zip(np.eye(3), ("root_x", "root_y", "root_z"), strict=True):
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    body.add_joint(name="root", type=mujoco.mjtJoint.mjJNT_BALL)
    return body


def _weld(spec: Any, foot: str) -> None:
    weld = spec.add_equality(
        name=f"{foot}_held", type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1="board", name2=MARK + foot,
    )  # fmt: skip
    # Zeros of place and turn ask for how both stand as described; torque counts as force.
    weld.data = np.array([*[0.0] * 10, 1.0, 0.0])


def _unmarked(mjcf: str) -> str:
    """Return a description whose parts bear their own names; classes keep the mark.

    Two descriptions may each have a class of one name, but no part.
    """
    root = ElementTree.fromstring(mjcf)
    for element in root.iter():
        for key, value in element.attrib.items():
            if value.startswith(MARK) and "class" not in key:
                element.set(key, value.removeprefix(MARK))
    return ElementTree.tostring(root, encoding="unicode")
