"""Measured facts of a description: shapes, inertias and poses, with trimesh and numpy."""

from __future__ import annotations

import warnings
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from experiments.plant.description import (
    Description,
    joint_in,
    link_in,
    numbers,
    parent_of,
)
from morph.arrays import Array


def rotation(rpy: list[float]) -> Array:
    """Return the rotation of URDF's fixed-axis roll, pitch and yaw, shape (3, 3)."""
    (a, b, c), (d, e, f) = np.cos(rpy), np.sin(rpy)
    roll = np.array([[1, 0, 0], [0, a, -d], [0, d, a]])
    pitch = np.array([[b, 0, e], [0, 1, 0], [-e, 0, b]])
    yaw = np.array([[c, -f, 0], [f, c, 0], [0, 0, 1]])
    turned: Array = yaw @ pitch @ roll
    return turned


def pose(element: ET.Element) -> Array:
    """Return the pose of an element's `origin`, shape (4, 4)."""
    origin, placed = element.find("origin"), np.eye(4)
    placed[:3, :3] = rotation(numbers(origin, "rpy", "0 0 0"))
    placed[:3, 3] = numbers(origin, "xyz", "0 0 0")
    return placed


def world(description: Description, link: str) -> Array:
    """Return the pose of a link in the base's frame, every joint at zero, shape (4, 4)."""
    placed = np.eye(4)
    while link in description.parents:
        joint = joint_in(description.robot, description.parents[link])
        placed, link = pose(joint) @ placed, parent_of(joint)
    return placed


@lru_cache(maxsize=512)
def triangles(file: Path) -> Any:
    """Return a mesh file as trimesh reads it, corners that coincide made one."""
    import trimesh

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return trimesh.load(file, force="mesh")


def shapes(description: Description, link: str) -> list[Any]:
    """Return the link's visual and collision shapes in its frame; none if a mesh is missing."""
    import trimesh

    found = []
    element = link_in(description.robot, link)
    for shape in (*element.findall("visual"), *element.findall("collision")):
        geometry = shape.find("geometry")
        kind = (
            next((g for g in geometry if isinstance(g.tag, str)), None)
            if geometry is not None
            else None
        )
        if kind is None:
            continue
        if kind.tag == "mesh":
            file = description.file_of(kind.get("filename", ""))
            if file is None:
                return []
            mesh = triangles(file).copy()
            mesh.apply_scale(numbers(kind, "scale", "1 1 1"))
        elif kind.tag == "box":
            mesh = trimesh.creation.box(numbers(kind, "size", ""))
        else:
            radius = float(kind.get("radius", 0.0))
            length = float(kind.get("length", 0.0)) or 2 * radius
            mesh = trimesh.creation.cylinder(radius=radius, height=length, sections=16)
        mesh.apply_transform(pose(shape))
        found.append(mesh)
    return [mesh for mesh in found if len(mesh.faces) > 3]


@dataclass(frozen=True, kw_only=True)
class Solid:
    """The convex hull of all that a link shows and touches with, in the link's frame."""

    low: Array
    """Least corner of its box, m."""
    high: Array
    """Greatest corner of its box, m."""
    volume: float
    """m^3."""
    moment: Array
    """Moments of inertia of unit mass about the centre of volume, m^2, shape (3, 3)."""

    @property
    def size(self) -> float:
        """Return the diagonal of its box, m."""
        return float(np.linalg.norm(self.high - self.low))


@lru_cache(maxsize=4096)
def solid(description: Description, link: str) -> Solid | None:
    """Return the hull of a link's shapes, or None without a full set of shapes.

    It is kept: only for descriptions that do not change between two calls.
    """
    import trimesh

    found = shapes(description, link)
    if not found:
        return None
    points = np.concatenate([mesh.vertices for mesh in found])
    if np.linalg.matrix_rank(points - points.mean(axis=0), tol=1e-6) < 3:
        return None
    hull = trimesh.convex.convex_hull(points)
    return Solid(
        low=points.min(axis=0),
        high=points.max(axis=0),
        volume=float(hull.volume),
        moment=np.asarray(hull.moment_inertia) / float(hull.mass),
    )


@dataclass(frozen=True, kw_only=True)
class Inertial:
    """What a link says of its mass."""

    mass: float
    """kg."""
    centre: Array
    """Centre of mass in the link's frame, m, shape (3,)."""
    turn: Array
    """Axes of `moment` in the link's frame, shape (3, 3)."""
    moment: Array
    """Inertia about the centre of mass, kg m^2, shape (3, 3)."""


def inertial(description: Description, link: str) -> Inertial | None:
    """Return a link's mass and inertia, or None where it gives none or a mass of zero."""
    element = link_in(description.robot, link).find("inertial")
    if element is None:
        return None
    mass = numbers(element.find("mass"), "value", "0")[0]
    figures = element.find("inertia")
    if mass <= 0 or figures is None:
        return None
    xx, xy, xz, yy, yz, zz = (
        float(figures.get(key, "0")) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    placed = pose(element)
    return Inertial(
        mass=mass,
        centre=placed[:3, 3],
        turn=placed[:3, :3],
        moment=np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
    )


def sound(moment: Array) -> bool:
    """Return whether some body can have this inertia: positive, and of three equal rights.

    Source: Traversaro et al. 2016, IROS, "Identification of fully physical consistent
    inertial parameters", eq. 16: each principal moment at most the sum of the others.
    """
    least, middle, most = np.linalg.eigvalsh(moment)
    return bool(least > 0 and most <= (least + middle) * (1 + 1e-9))


def moves(description: Description, link: str) -> bool:
    """Return whether the joint that carries a link lets it move."""
    if link not in description.parents:
        return False
    return joint_in(description.robot, description.parents[link]).get("type") != "fixed"


def total_mass(description: Description) -> float:
    """Return the mass of all links, kg."""
    found = (inertial(description, link) for link in description.links)
    return sum(one.mass for one in found if one)
