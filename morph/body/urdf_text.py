"""A robot as URDF text that MuJoCo, Pinocchio and yourdfpy read alike."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.follow import followers
from morph.body.quiet import quiet
from morph.body.robot import Joint, Robot
from morph.body.urdf_omissions import few, omissions
from morph.body.urdf_shapes import Shapes, matrix, number, numbers, origin

TOKEN = 1e-12
"""Mass, kg, and inertia, kg m2, of a link between two joints on one body: nobody moves less."""

LEAST = 2e-14
"""Least principal moment written, kg m2: MuJoCo takes no URDF with one below 1e-14."""

MARGIN = 1e-11
"""By how much, of the greatest moment, the other two exceed it."""

WORLD = "world"
"""The root link, which ties the base: without it MuJoCo drops the base's mass."""

HINGE, SLIDE = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE

FAR = 50.0
"""Range of a slide without limits, m: URDF wants one."""

STRONG = 1e3
"""Effort, N m or N, and speed, rad/s or m/s, where none is given: URDF wants both."""

AXES = {"x": 0, "y": 1, "z": 2}
PAIRS = (("x", "x"), ("x", "y"), ("x", "z"), ("y", "y"), ("y", "z"), ("z", "z"))


def urdf_text(robot: Robot, meshes: str) -> tuple[str, dict[str, bytes], tuple[str, ...]]:
    """Return a robot as URDF, the mesh files that it names, and what it cannot hold.

    Every joint is at zero where the robot is at home.

    Args:
        robot: The robot.
        meshes: The folder that the URDF names mesh files in.
    """
    spec = mujoco.MjSpec.from_string(robot.mjcf, assets=dict(robot.assets))
    with quiet():
        model = spec.compile()
    writer = _Writer(robot, model, Shapes(model, meshes))
    writer.write()
    ElementTree.indent(writer.tree)
    text = '<?xml version="1.0"?>\n' + ElementTree.tostring(writer.tree, encoding="unicode") + "\n"
    left_out = [*writer.left_out, *writer.shapes.left_out, *omissions(robot, model)]
    return text, writer.shapes.assets, tuple(dict.fromkeys(left_out))


class _Writer:
    """Writes links and joints in the order of the tree."""

    def __init__(self, robot: Robot, model: Any, shapes: Shapes) -> None:
        self.robot, self.model, self.shapes = robot, model, shapes
        self.tree = ElementTree.Element("robot", name=writable_name(robot.name))
        self.follows, tied = followers(model)
        self.left_out = [f"how {name!r} is tied" for name in tied]
        self.unlimited: dict[str, list[str]] = {"effort": [], "speed": []}
        self.links = {WORLD, *(link.name for link in robot.links)}
        self.joints = {joint.name for joint in robot.joints}

    def write(self) -> None:
        # Read by MuJoCo alone: keep every link, look and folder, and weigh no shape.
        extension = ElementTree.SubElement(self.tree, "mujoco")
        kept = ("fusestatic", "discardvisual", "strippath", "balanceinertia", "inertiafromgeom")
        ElementTree.SubElement(extension, "compiler", dict.fromkeys(kept, "false"))
        world = ElementTree.SubElement(self.tree, "link", name=WORLD)
        self.shapes.add(world, 0, np.zeros(3))
        for body in range(1, self.model.nbody):
            self.body(body)
        for what, names in self.unlimited.items():
            if names:
                text = f"that no limit of {what} is known of {few(names)}: {STRONG:g} stands there"
                self.left_out.append(text)

    def body(self, body: int) -> None:
        model = self.model
        name = model.body(body).name
        joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        parent = model.body(model.body_parentid[body]).name
        # URDF turns a link about its own origin, MuJoCo about an anchor: shift the frame.
        turn = matrix(model.body_quat[body])
        anchor = model.jnt_pos[joints[-1]] if len(joints) else np.zeros(3)
        place = model.body_pos[body] - anchor_of(model, model.body_parentid[body])
        before = np.zeros(3)
        for count, joint in enumerate(joints):
            last = count == len(joints) - 1
            child = name if last else unused(f"{name}_{count + 1}", self.links)
            here = model.jnt_pos[joint]
            pose = (place + turn @ here, turn) if count == 0 else (here - before, np.eye(3))
            self.joint(joint, parent, child, pose)
            if not last:
                self.token(child)
            parent, before = child, here
        if not len(joints):
            title = unused(f"{name} is fixed", self.joints)
            self.link_joint(title, "fixed", parent, name, (place, turn))
        link = ElementTree.SubElement(self.tree, "link", name=name)
        self.inertia(link, body, anchor)
        self.shapes.add(link, body, anchor)

    def link_joint(
        self, name: str, kind: str, parent: str, child: str, pose: tuple[Array, Array]
    ) -> ElementTree.Element:
        element = ElementTree.SubElement(self.tree, "joint", name=name, type=kind)
        origin(element, *pose)
        ElementTree.SubElement(element, "parent", link=parent)
        ElementTree.SubElement(element, "child", link=child)
        return element

    def joint(self, joint: int, parent: str, child: str, pose: tuple[Array, Array]) -> None:
        model = self.model
        name = model.joint(joint).name
        sort = mujoco.mjtJoint(model.jnt_type[joint])
        if sort == mujoco.mjtJoint.mjJNT_BALL:
            self.ball(name, parent, child, pose)
            return
        if sort not in (HINGE, SLIDE):
            self.link_joint(name, "floating", parent, child, pose)
            return
        known = self.robot.joint(name)
        kind = "prismatic" if sort == SLIDE else "revolute" if known.limits else "continuous"
        element = self.link_joint(name, kind, parent, child, pose)
        ElementTree.SubElement(element, "axis", xyz=numbers(model.jnt_axis[joint]))
        self.limit(element, joint, known)
        address = model.jnt_dofadr[joint]
        damping, friction = np.ravel(model.dof_damping[address]), model.dof_frictionloss[address]
        if np.any(damping) or friction:
            held = {"damping": number(damping[0]), "friction": number(float(friction))}
            ElementTree.SubElement(element, "dynamics", held)
        if np.any(damping[1:]):
            self.left_out.append(f"how the damping of {name!r} grows with speed")
        if joint in self.follows:
            mimic = self.follows[joint]
            held = {"joint": mimic.joint, "multiplier": number(mimic.ratio)}
            held["offset"] = number(mimic.offset)
            ElementTree.SubElement(element, "mimic", held)

    def limit(self, element: ElementTree.Element, joint: int, known: Joint) -> None:
        """Add a joint's `<limit>`, its range as seen from home."""
        home = float(self.model.qpos0[self.model.jnt_qposadr[joint]])
        held = {}
        if known.limits is not None:
            held = {
                "lower": number(known.limits[0] - home),
                "upper": number(known.limits[1] - home),
            }
        elif known.kind == "slide":
            held = {"lower": number(-FAR), "upper": number(FAR)}
            self.left_out.append(f"that {known.name!r} slides without end: {FAR:g} m each way")
        if home:
            self.left_out.append(f"that {known.name!r} stands at {home:.4g} at home: zero is there")
        driven = [each.limit for each in self.robot.actuators if each.joint == known.name]
        effort = known.effort or max((limit for limit in driven if limit), default=None)
        for what, value in (("effort", effort), ("speed", known.velocity)):
            if value is None:
                self.unlimited[what].append(known.name)
        held["effort"] = number(STRONG if effort is None else effort)
        held["velocity"] = number(known.velocity or STRONG)
        ElementTree.SubElement(element, "limit", held)

    def ball(self, name: str, parent: str, child: str, pose: tuple[Array, Array]) -> None:
        self.left_out.append(f"the ball joint {name!r}, which became three hinges")
        for letter, axis in zip("xyz", np.eye(3), strict=True):
            end = child if letter == "z" else unused(f"{child}_about_{letter}", self.links)
            title = unused(f"{name}_about_{letter}", self.joints)
            element = self.link_joint(title, "continuous", parent, end, pose)
            ElementTree.SubElement(element, "axis", xyz=numbers(axis))
            held = {"effort": number(STRONG), "velocity": number(STRONG)}
            ElementTree.SubElement(element, "limit", held)
            if end != child:
                self.token(end)
            parent, pose = end, (np.zeros(3), np.eye(3))

    def token(self, name: str) -> None:
        link = ElementTree.SubElement(self.tree, "link", name=name)
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "mass", value=number(TOKEN))
        moments = {f"i{a}{b}": number(TOKEN if a == b else 0.0) for a, b in PAIRS}
        ElementTree.SubElement(inertial, "inertia", moments)

    def inertia(self, link: ElementTree.Element, body: int, anchor: Array) -> None:
        model = self.model
        if model.body_mass[body] <= 0:
            return
        inertial = ElementTree.SubElement(link, "inertial")
        origin(inertial, model.body_ipos[body] - anchor, np.eye(3))
        ElementTree.SubElement(inertial, "mass", value=number(float(model.body_mass[body])))
        axes = matrix(model.body_iquat[body])
        full = axes @ np.diag(writable(model.body_inertia[body])) @ axes.T
        moments = {f"i{a}{b}": number(float(full[AXES[a], AXES[b]])) for a, b in PAIRS}
        ElementTree.SubElement(inertial, "inertia", moments)


def writable_name(name: str) -> str:
    """Return a name in letters that XML can hold: a file's own name may have others."""
    return "".join(letter if letter.isprintable() else "_" for letter in name)


def writable(moments: Array) -> Array:
    """Return principal moments, kg m2, that still are a body's once they are read back.

    The moments of a flat body lie on the edge of what is possible, A + B = C, and
    readers that take the full inertia apart again err by a few parts in 1e12.
    """
    held = np.maximum(moments, LEAST)
    lack = held.max() * (2.0 + MARGIN) - held.sum()
    held[np.argmin(held)] += max(lack, 0.0)
    return held


def unused(name: str, taken: set[str]) -> str:
    """Return a name, or one like it, that nothing has; from now on it is taken."""
    free, count = name, 1
    while free in taken:
        count += 1
        free = f"{name}_{count}"
    taken.add(free)
    return free


def anchor_of(model: Any, body: int) -> Array:
    """Return by how much a body's frame was shifted to its last joint's anchor, m."""
    count = model.body_jntnum[body]
    if not count:
        return np.zeros(3)
    anchor: Array = model.jnt_pos[model.body_jntadr[body] + count - 1]
    return anchor
