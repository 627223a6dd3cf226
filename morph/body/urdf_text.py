"""A robot as URDF text that MuJoCo, Pinocchio and yourdfpy read alike."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh, as_stl
from morph.body.mjcf_draft import roles
from morph.body.robot import Robot

TOKEN = 1e-12
"""Mass, kg, and inertia, kg m2, of a link between two joints on one body: nobody moves less."""

WORLD = "world"
"""The root link, which ties the base: without it MuJoCo drops the base's mass."""

KINDS = {mujoco.mjtJoint.mjJNT_HINGE: "revolute", mujoco.mjtJoint.mjJNT_SLIDE: "prismatic"}
"""What URDF calls MuJoCo's joints."""

FAR = 50.0
"""Range of a slide without limits, m: URDF wants one."""

STRONG = 1e3
"""Effort, N m or N, and speed, rad/s or m/s, where none is given: URDF wants both."""


def urdf_text(robot: Robot, meshes: str) -> tuple[str, dict[str, bytes], tuple[str, ...]]:
    """Return a robot as URDF, the mesh files that it names, and what it cannot hold.

    Args:
        robot: The robot.
        meshes: The folder that the URDF names mesh files in.
    """
    spec = mujoco.MjSpec.from_string(robot.mjcf, assets=dict(robot.assets))
    writer = _Writer(robot, spec.compile(), meshes)
    writer.write()
    ElementTree.indent(writer.tree)
    text = '<?xml version="1.0"?>\n' + ElementTree.tostring(writer.tree, encoding="unicode") + "\n"
    return text, writer.assets, tuple(dict.fromkeys(writer.left_out))


class _Writer:
    """Writes links and joints in the order of the tree."""

    def __init__(self, robot: Robot, model: Any, meshes: str) -> None:
        self.robot, self.model, self.meshes = robot, model, meshes
        self.tree = ElementTree.Element("robot", name=robot.name)
        self.assets: dict[str, bytes] = {}
        self.left_out: list[str] = []

    def write(self) -> None:
        # Read by MuJoCo alone: keep every link, look and folder.
        extension = ElementTree.SubElement(self.tree, "mujoco")
        kept = {"fusestatic": "false", "discardvisual": "false", "strippath": "false"}
        ElementTree.SubElement(extension, "compiler", {**kept, "balanceinertia": "false"})
        world = ElementTree.SubElement(self.tree, "link", name=WORLD)
        self.shapes(world, 0, np.zeros(3))
        for body in range(1, self.model.nbody):
            self.body(body)
        self.omissions()

    def body(self, body: int) -> None:
        model = self.model
        name = model.body(body).name
        joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        parent = model.body(model.body_parentid[body]).name
        # URDF turns a link about its own origin, MuJoCo about an anchor: shift the frame.
        turn = matrix(model.body_quat[body])
        anchor = model.jnt_pos[joints[-1]] if len(joints) else np.zeros(3)
        place = model.body_pos[body] - turn_parent(model, body)
        for count, joint in enumerate(joints):
            last = count == len(joints) - 1
            child = name if last else f"{name}_{count + 1}"
            pose = (place + turn @ anchor, turn) if count == 0 else (np.zeros(3), np.eye(3))
            self.joint(joint, parent, child, pose)
            if not last:
                self.token(child)
            parent = child
        if not len(joints):
            self.link_joint(f"{name} is fixed", "fixed", parent, name, (place, turn))
        link = ElementTree.SubElement(self.tree, "link", name=name)
        self.inertia(link, body, anchor)
        self.shapes(link, body, anchor)

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
        if sort not in KINDS:
            self.link_joint(name, "floating", parent, child, pose)
            return
        known = self.robot.joint(name)
        kind = "continuous" if sort == 3 and known.limits is None else KINDS[sort]
        element = self.link_joint(name, kind, parent, child, pose)
        ElementTree.SubElement(element, "axis", xyz=numbers(model.jnt_axis[joint]))
        low, high = known.limits or (-FAR, FAR)
        if known.limits is None and kind == "prismatic":
            self.left_out.append(f"that {name!r} slides without end: {FAR:g} m each way")
        limit = {} if kind == "continuous" else {"lower": number(low), "upper": number(high)}
        effort, speed = known.effort, known.velocity
        driven = [a.limit for a in self.robot.actuators if a.joint == name and a.limit]
        limit["effort"] = number(effort or max(driven, default=0.0) or STRONG)
        limit["velocity"] = number(speed or STRONG)
        ElementTree.SubElement(element, "limit", limit)
        address = model.jnt_dofadr[joint]
        damping, friction = model.dof_damping[address], model.dof_frictionloss[address]
        if np.any(damping) or friction:
            first = float(np.ravel(damping)[0])
            held = {"damping": number(first), "friction": number(float(friction))}
            ElementTree.SubElement(element, "dynamics", held)
        if known.mimic is not None:
            held = {"joint": known.mimic.joint, "multiplier": number(known.mimic.ratio)}
            ElementTree.SubElement(element, "mimic", {**held, "offset": number(known.mimic.offset)})

    def ball(self, name: str, parent: str, child: str, pose: tuple[Array, Array]) -> None:
        self.left_out.append(f"the ball joint {name!r}, which became three hinges")
        for letter, axis in zip("xyz", np.eye(3), strict=True):
            end = child if letter == "z" else f"{child}_about_{letter}"
            element = self.link_joint(f"{name}_about_{letter}", "continuous", parent, end, pose)
            ElementTree.SubElement(element, "axis", xyz=numbers(axis))
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
        full = axes @ np.diag(model.body_inertia[body]) @ axes.T
        moments = {f"i{a}{b}": number(float(full[XYZ[a], XYZ[b]])) for a, b in PAIRS}
        ElementTree.SubElement(inertial, "inertia", moments)

    def shapes(self, link: ElementTree.Element, body: int, anchor: Array) -> None:
        model = self.model
        first = model.body_geomadr[body]
        for geom in range(first, first + model.body_geomnum[body]) if first >= 0 else ():
            turn = matrix(model.geom_quat[geom])
            place = model.geom_pos[geom] - anchor
            for role in roles(model, geom):
                for shape, along in self.primitives(geom):
                    element = ElementTree.SubElement(link, role)
                    origin(element, place + turn @ np.array((0.0, 0.0, along)), turn)
                    ElementTree.SubElement(element, "geometry").append(shape)
                    if role == "visual":
                        self.colour(element, geom)

    def primitives(self, geom: int) -> list[tuple[ElementTree.Element, float]]:
        """Return a geom as URDF's shapes, each with its height along the geom's axis."""
        model, element = self.model, ElementTree.Element
        a, b, c = model.geom_size[geom].tolist()
        kind = mujoco.mjtGeom(model.geom_type[geom])
        if kind == mujoco.mjtGeom.mjGEOM_BOX:
            return [(element("box", size=numbers((2 * a, 2 * b, 2 * c))), 0.0)]
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            return [(element("sphere", radius=number(a)), 0.0)]
        if kind in (mujoco.mjtGeom.mjGEOM_CYLINDER, mujoco.mjtGeom.mjGEOM_CAPSULE):
            parts = [(element("cylinder", radius=number(a), length=number(2 * b)), 0.0)]
            if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
                parts += [(element("sphere", radius=number(a)), end) for end in (-b, b)]
            return parts
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            return [(element("mesh", filename=self.mesh(model.geom_dataid[geom])), 0.0)]
        if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            file = f"ellipsoid_{geom}.stl"
            self.assets[file] = as_stl(ellipsoid(a, b, c))
            return [(element("mesh", filename=f"{self.meshes}/{file}"), 0.0)]
        self.left_out.append(f"a shape of the kind {kind.name.removeprefix('mjGEOM_').lower()}")
        return []

    def mesh(self, mesh: int) -> str:
        model = self.model
        vertex, face = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
        file = f"{mesh}_{model.mesh(mesh).name}.stl".replace("/", "_")
        self.assets[file] = as_stl(
            Mesh(
                vertices=model.mesh_vert[vertex : vertex + model.mesh_vertnum[mesh]].astype(float),
                faces=model.mesh_face[face : face + model.mesh_facenum[mesh]].astype(np.int64),
            )
        )
        return f"{self.meshes}/{file}"

    def colour(self, element: ElementTree.Element, geom: int) -> None:
        model = self.model
        held = model.geom_matid[geom]
        rgba = model.geom_rgba[geom] if held < 0 else model.mat_rgba[held]
        material = ElementTree.SubElement(element, "material", name=f"colour_{geom}")
        ElementTree.SubElement(material, "color", rgba=numbers(rgba))

    def omissions(self) -> None:
        model, robot = self.model, self.robot
        servos = [actuator.name for actuator in robot.actuators if actuator.kind == "position"]
        if servos:
            self.left_out.append(f"the gains of {len(servos)} servos")
        if np.any(model.dof_armature):
            self.left_out.append("the rotors' inertia (armature)")
        if np.any(model.jnt_stiffness):
            self.left_out.append("the joints' springs")
        for loop in robot.loops:
            self.left_out.append(f"the closed chain {loop.name or ' and '.join(loop.links)}")
        if robot.sensors:
            self.left_out.append(f"{len(robot.sensors)} sensors")


XYZ = {"x": 0, "y": 1, "z": 2}
PAIRS = ("xx", "xy", "xz", "yy", "yz", "zz")


def ellipsoid(a: float, b: float, c: float) -> Mesh:
    """Return an ellipsoid's mesh of 16 by 8 patches, with the half axes a, b and c."""
    turns, rises = np.linspace(0, 2 * np.pi, 17)[:-1], np.linspace(-np.pi / 2, np.pi / 2, 9)
    rows = [
        [(np.cos(r) * np.cos(t), np.cos(r) * np.sin(t), np.sin(r)) for t in turns] for r in rises
    ]
    points = np.array(rows).reshape(-1, 3) * (a, b, c)
    index = np.arange(9 * 16).reshape(9, 16)
    low, high = index[:-1], index[1:]
    right, above = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    first = np.stack([low, right, above], axis=-1)[1:].reshape(-1, 3)
    second = np.stack([low, above, high], axis=-1)[:-1].reshape(-1, 3)
    return Mesh(vertices=points, faces=np.concatenate([first, second]))


def turn_parent(model: Any, body: int) -> Array:
    """Return by how much the parent's frame was shifted to its joint's anchor, m."""
    parent = model.body_parentid[body]
    count = model.body_jntnum[parent]
    if not count:
        return np.zeros(3)
    anchor: Array = model.jnt_pos[model.body_jntadr[parent] + count - 1]
    return anchor


def matrix(quaternion: Array) -> Array:
    """Return a quaternion w, x, y, z as a rotation matrix, shape (3, 3)."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, quaternion)
    return turn.reshape(3, 3)


def angles(turn: Array) -> tuple[float, float, float]:
    """Return a rotation matrix as URDF's roll, pitch and yaw, rad.

    The inverse of `morph.body.numbers.rotation`; straight up or down, roll is 0.
    """
    across = math.hypot(turn[0, 0], turn[1, 0])
    pitch = math.atan2(-turn[2, 0], across)
    if across < 1e-12:
        return 0.0, pitch, math.atan2(-turn[0, 1], turn[1, 1])
    roll = math.atan2(turn[2, 1], turn[2, 2])
    return roll, pitch, math.atan2(turn[1, 0], turn[0, 0])


def origin(element: ElementTree.Element, place: Array, turn: Array) -> None:
    """Add an `<origin>`."""
    held = {"xyz": numbers(place), "rpy": numbers(angles(turn))}
    ElementTree.SubElement(element, "origin", held)


def number(value: float) -> str:
    """Return a number from whose text the same double comes back."""
    return repr(float(value) + 0.0)


def numbers(values: Any) -> str:
    """Return numbers, with a space between them."""
    return " ".join(number(value) for value in values)
