"""A robot that collides as convex pieces of its meshes, not as their hulls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco

from morph.body.check.collision import leave_out
from morph.body.mesh import as_stl, read_mesh
from morph.body.normal import robot_of
from morph.body.pieces import Cutting, Pieces, convex_pieces
from morph.body.quiet import quiet
from morph.body.robot import Robot
from morph.body.spec import bare_spec
from morph.errors import MeshError
from morph.files import sha256

ENOUGH = 1.05
"""Ratio of hull to mesh below which a mesh is left as it is: it is convex but for rounding."""


@dataclass(frozen=True, kw_only=True)
class Cut:
    """What became of one collision mesh."""

    link: str
    """The link that collides with it."""
    mesh: str
    """The mesh's name."""
    pieces: int
    """Convex pieces in its place; 1 if it stays as its hull."""
    hull_ratio: float
    """Volume of its hull, by its own."""
    pieces_ratio: float
    """Volume of the pieces together, by its own."""


def with_pieces(
    robot: Robot, cutting: Cutting | None = None, *, progress: Callable[[str], None] | None = None
) -> tuple[Robot, tuple[Cut, ...]]:
    """Return a robot whose collision meshes are convex pieces, and what was cut.

    Masses and inertias stay. Cutting a mesh takes seconds to minutes the first time
    and is then read from the cache (`morph.body.pieces`).

    Args:
        robot: The robot.
        cutting: How to cut.
        progress: Called with each mesh's name before it is cut.

    Raises:
        RobotError: A mesh cannot be read, or MuJoCo refuses a piece.
    """
    spec = bare_spec(robot)
    assets = dict(robot.assets)
    meshes = {mesh.name or Path(mesh.file).stem: mesh for mesh in spec.meshes}
    results: dict[str, Pieces | None] = {}
    cuts = []
    for geom in list(spec.geoms):
        touches = geom.contype or geom.conaffinity
        if geom.type != mujoco.mjtGeom.mjGEOM_MESH or not touches:
            continue
        name = geom.meshname
        if name not in results:
            if progress is not None:
                progress(name)
            results[name] = _cut(meshes[name], assets, cutting)
        pieces = results[name]
        if pieces is None:
            continue
        whole = pieces.hull_ratio < ENOUGH
        cuts.append(
            Cut(
                link=geom.parent.name,
                mesh=name,
                pieces=1 if whole else len(pieces.meshes),
                hull_ratio=pieces.hull_ratio,
                pieces_ratio=pieces.hull_ratio if whole else pieces.pieces_ratio,
            )
        )
        if not whole:
            _exchange(spec, geom, meshes[name], pieces, assets)
    if robot.source is not None and robot.source.suffix.lower() == ".urdf":
        # What hulls overlapped, pieces may not.
        for exclude in list(spec.excludes):
            spec.delete(exclude)
        spec.assets = assets
        with quiet():
            leave_out(spec, spec.compile())
    cut = robot_of(spec, robot.source or Path(robot.name), robot.card, assets)
    shapes = {link.name: link.shapes for link in cut.links}
    changed = replace(
        robot,
        mjcf=cut.mjcf,
        assets=cut.assets,
        links=tuple(replace(link, shapes=shapes[link.name]) for link in robot.links),
        sha256=sha256(robot.sha256, "pieces", repr(cutting or Cutting())),
    )
    return changed, tuple(cuts)


def _cut(element: Any, assets: dict[str, bytes], cutting: Cutting | None) -> Pieces | None:
    content = assets.get(element.file)
    if content is None:
        return None
    try:
        return convex_pieces(read_mesh(content, Path(element.file).suffix, element.file), cutting)
    except MeshError:
        return None  # A sheet encloses nothing to cut; MuJoCo takes its hull.


def _exchange(spec: Any, geom: Any, element: Any, pieces: Pieces, assets: dict[str, bytes]) -> None:
    body = geom.parent
    for number, piece in enumerate(pieces.meshes):
        name = f"{geom.meshname}_piece_{number}"
        file = f"{Path(element.file).stem}_piece_{number}.stl"
        if file not in assets:
            assets[file] = as_stl(piece)
            spec.add_mesh(
                name=name,
                file=file,
                scale=element.scale,
                refpos=element.refpos,
                refquat=element.refquat,
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
            )
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            pos=geom.pos,
            quat=geom.quat,
            rgba=geom.rgba,
            mass=0.0,
            group=3,
            contype=geom.contype,
            conaffinity=geom.conaffinity,
            condim=geom.condim,
            friction=geom.friction,
            solref=geom.solref,
            solimp=geom.solimp,
            margin=geom.margin,
        )
    if geom.group > 2:
        spec.delete(geom)
    else:
        geom.contype = geom.conaffinity = 0  # It is still to be seen.
