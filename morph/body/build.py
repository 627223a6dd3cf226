"""From a draft, once checked, to a `mujoco.MjSpec`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from morph.arrays import Array
from morph.body.check.place import WORLD
from morph.body.draft import Draft, DraftJoint, DraftLink, Shape
from morph.body.follow import QUICK, RIGID
from morph.body.mesh import Mesh, as_stl

VISUAL_GROUP, COLLISION_GROUP = 1, 3
"""Groups of geoms, so that a viewer shows the one and can show the other."""

GREY = (0.7, 0.7, 0.7, 1.0)
"""Colour of a shape that has none."""

LEAST_AREA = 1e-12
"""Area of a mesh that is left out, m2, with room above MuJoCo's own least of 1e-15."""

HINGE, SLIDE = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE


def spec_from(draft: Draft, base: str) -> tuple[Any, dict[str, bytes]]:
    """Return a draft as a `mujoco.MjSpec`, and the mesh files that it names.

    Args:
        draft: A draft that every check has passed or repaired: one tree, with
            masses wherever it moves.
        base: `fixed` (the root stands in the world, its mass is counted),
            `floating`, or `board` (it slides along x, on wheels without friction).
    """
    builder = _Builder(draft)
    (root,) = draft.roots()
    builder.root(draft.link(root), base)
    for joint in draft.joints:
        builder.follow(joint)
    return builder.spec, builder.assets


@dataclass
class _Builder:
    """Adds links in the order of the tree."""

    draft: Draft
    spec: Any = field(default_factory=mujoco.MjSpec)
    assets: dict[str, bytes] = field(default_factory=dict)
    meshes: dict[tuple[int, tuple[float, ...]], str] = field(default_factory=dict)
    files: dict[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.spec.modelname = self.draft.name
        self.spec.compiler.degree = False
        self.spec.compiler.autolimits = True
        self.below: dict[str, list[DraftJoint]] = {}
        for joint in self.draft.joints:
            self.below.setdefault(joint.parent, []).append(joint)
        self.links = {link.name: link for link in self.draft.links}
        self.joints = {joint.name for joint in self.draft.joints}

    def new(self, name: str) -> str:
        """Return a name for a joint that the description does not have; unlike any other."""
        chosen, number = name, 2
        while chosen in self.joints:
            chosen, number = f"{name}_{number}", number + 1
        self.joints.add(chosen)
        return chosen

    def root(self, link: DraftLink, base: str) -> None:
        body = self.spec.worldbody
        if link.name != WORLD:
            body = body.add_body(name=link.name)
            self.stand(body, base)
        self.link(body, link)
        queue = [(link.name, body)]
        while queue:
            name, parent = queue.pop()
            # MuJoCo numbers siblings as they are made: in the file's order.
            for joint in self.below.get(name, []):
                queue.append((joint.child, self.child(parent, joint, base)))

    def stand(self, body: Any, base: str) -> None:
        if base == "floating":
            body.add_freejoint(name=self.new("root"))
        elif base == "board":
            body.add_joint(name=self.new("board"), type=SLIDE, axis=(1, 0, 0))

    def child(self, parent: Any, joint: DraftJoint, base: str) -> Any:
        body = parent.add_body(
            name=joint.child, pos=joint.pose.position, quat=quaternion(joint.pose.rotation)
        )
        top = parent.id == self.spec.worldbody.id and parent.name == WORLD
        if top and joint.kind == "fixed":
            self.stand(body, base)
        elif top and joint.kind == "floating":
            body.add_freejoint(name=joint.name)
        else:
            self.joint(body, joint)
        self.link(body, self.links[joint.child])
        return body

    def joint(self, body: Any, joint: DraftJoint) -> None:
        if joint.kind == "planar":
            first, second = _across(joint.axis)
            body.add_joint(name=self.new(f"{joint.name}_x"), type=SLIDE, axis=first)
            body.add_joint(name=self.new(f"{joint.name}_y"), type=SLIDE, axis=second)
            body.add_joint(name=joint.name, type=HINGE, axis=joint.axis)
            return
        if joint.kind == "floating":
            for axis, letter in zip(np.eye(3), "xyz", strict=True):
                body.add_joint(name=self.new(f"{joint.name}_{letter}"), type=SLIDE, axis=axis)
        if joint.kind in ("floating", "ball"):
            body.add_joint(name=joint.name, type=mujoco.mjtJoint.mjJNT_BALL)
            return
        if joint.kind == "fixed":
            return
        added = body.add_joint(
            name=joint.name,
            type=SLIDE if joint.kind == "prismatic" else HINGE,
            axis=joint.axis,
            damping=np.array((joint.damping, 0.0, 0.0)),
            frictionloss=joint.friction,
        )
        if joint.kind != "continuous" and joint.lower is not None and joint.upper is not None:
            added.limited, added.range = True, (joint.lower, joint.upper)
        if joint.effort is not None:
            added.actfrclimited, added.actfrcrange = True, (-joint.effort, joint.effort)

    def follow(self, joint: DraftJoint) -> None:
        if joint.mimic is not None:
            data = np.zeros(12)
            data[:2] = joint.mimic.offset, joint.mimic.ratio
            self.spec.add_equality(
                name=f"{joint.name} follows {joint.mimic.joint}",
                type=mujoco.mjtEq.mjEQ_JOINT,
                objtype=mujoco.mjtObj.mjOBJ_JOINT,
                name1=joint.name,
                name2=joint.mimic.joint,
                data=data,
                solimp=np.array(RIGID),
                solref=np.array(QUICK),
            )

    def link(self, body: Any, link: DraftLink) -> None:
        mass = link.mass or 0.0
        if body.name != WORLD:
            body.explicitinertial, body.mass, body.ipos = True, mass, link.com
            moments, axes = principal(link.inertia if mass and link.inertia is not None else None)
            body.inertia, body.iquat = moments, quaternion(axes)
        for shape in link.shapes:
            self.shape(body, shape)

    def shape(self, body: Any, shape: Shape) -> None:
        kinds = mujoco.mjtGeom
        settings: dict[str, Any] = {}
        pose = shape.pose
        if shape.kind == "mesh":
            if shape.mesh is None or not visible(shape.mesh.scaled(shape.scale)):
                return
            settings = {"type": kinds.mjGEOM_MESH, "meshname": self.mesh(shape, shape.mesh)}
        elif min(shape.size) > 0:
            half = np.array(shape.size) / 2
            size = {
                "box": tuple(half),
                "sphere": (shape.size[0], 0, 0),
                "cylinder": (shape.size[0], half[-1], 0),
                "capsule": (shape.size[0], half[-1], 0),
            }[shape.kind]
            settings = {"type": getattr(kinds, f"mjGEOM_{shape.kind.upper()}"), "size": size}
        else:
            return
        visual = shape.role == "visual"
        body.add_geom(
            pos=pose.position,
            quat=quaternion(pose.rotation),
            rgba=shape.colour or GREY,
            mass=0.0,
            group=VISUAL_GROUP if visual else COLLISION_GROUP,
            contype=0 if visual else 1,
            conaffinity=0 if visual else 1,
            **settings,
        )

    def mesh(self, shape: Shape, mesh: Mesh) -> str:
        key = (id(mesh), shape.scale)
        if key not in self.meshes:
            stem = shape.path.stem if shape.path else shape.file or "mesh"
            file = self.files.get(id(mesh)) or f"{len(self.files)}_{stem}.stl"
            if id(mesh) not in self.files:
                self.files[id(mesh)], self.assets[file] = file, as_stl(mesh)
            name = self.meshes[key] = f"{len(self.meshes)}_{stem}"
            # A shell has moments even if it is open or inside out; masses are explicit.
            self.spec.add_mesh(
                name=name,
                file=file,
                scale=shape.scale,
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
            )
        return self.meshes[key]


def quaternion(rotation: Array) -> Array:
    """Return a rotation matrix, shape (3, 3), as w, x, y, z."""
    result = np.zeros(4)
    mujoco.mju_mat2Quat(result, np.ascontiguousarray(rotation).ravel())
    return result


def principal(inertia: Array | None) -> tuple[Array, Array]:
    """Return principal moments, greatest last, and their axes as columns, right-handed."""
    if inertia is None:
        return np.zeros(3), np.eye(3)
    moments, axes = np.linalg.eigh(inertia)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    # Rounding must not break what holds in the limit, of a rod or a flat body.
    moments = np.maximum(moments, 0.0)
    moments[2] = min(moments[2], moments[0] + moments[1])
    return moments, axes


def visible(mesh: Mesh) -> bool:
    """Return whether a mesh has an area and an extent in all directions, as MuJoCo wants."""
    points = mesh.vertices - mesh.bounds.mean(axis=0)
    spread = np.linalg.eigvalsh(points.T @ points)
    a, b, c = (points[mesh.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    return bool(area > LEAST_AREA and spread[0] > 1e-14 * spread[2] and len(mesh.vertices) >= 4)


def _across(axis: Array) -> tuple[Array, Array]:
    _, _, rows = np.linalg.svd(axis[None])
    return rows[1], rows[2]
