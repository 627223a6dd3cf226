"""Which surface of a link water touches: its own solid, a wrap, a hull or a box, and why."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from morph.arrays import Array, Integers
from morph.body.mesh import Mesh
from morph.body.robot import Robot
from morph.errors import MeshError, RobotError
from morph.physics.fluid.wetted.box import Box, as_box, equivalent_box
from morph.physics.fluid.wetted.remesh import even
from morph.physics.fluid.wetted.shapes import shapes_of
from morph.physics.fluid.wetted.solid import as_manifold, from_manifold, joined
from morph.physics.fluid.wetted.sound import sound
from morph.physics.fluid.wetted.wrap import sealing_radius, wrapped

How = Literal["mesh", "wrap", "hull", "box"]

WAYS = ("mesh", "hull", "box")
"""What may be asked for; a mesh that bounds no solid is wrapped."""

PANELS, FEW = 1280, 400
"""Panels of the surface, and of those that are only compared."""

CELLS = (96, 48)
"""Points along the greatest extent when wrapping; the first is used, both are compared."""

FACET = 1e-3
"""How far the hull of a fine mesh may be off, as a part of its diagonal."""


@dataclass(frozen=True, kw_only=True)
class Choice:
    """One surface that might stand for a link, and what it would mean."""

    how: str
    """`wrap`, `wrap, coarser`, `hull` or `box`."""
    volume: float
    """Volume displaced, m3."""
    added: Array
    """Diagonal of the added-mass tensor at unit density about the volume's centre, shape (6,)."""


@dataclass(frozen=True, kw_only=True)
class Wetted:
    """The surface of a link that water touches."""

    vertices: Array
    """Corners in the link's frame, m, shape (n, 3)."""
    faces: Integers
    """Triangles, counter-clockwise from outside, shape (m, 3); every piece closed."""
    volume: float
    """Volume displaced, m3."""
    centre: Array
    """Centre of that volume, shape (3,), m."""
    how: How
    """What it is: the link's own `mesh`, a `wrap` of it, its `hull`, or a `box`."""
    reason: str = ""
    """Why it is not the link's shapes as they are; empty if it is."""
    spread: Array | None = None
    """Of each diagonal entry of the added mass, the range over the choices by the entry itself,
    shape (6,); None for a surface that is as the link's shapes say."""
    choices: tuple[Choice, ...] = ()
    """The surfaces compared; empty where there was nothing to choose."""
    box: Box | None = None
    """Set where the surface is that of one box, whose tensor has a quicker way."""


def wetted(
    robot: Robot,
    link: str,
    *,
    how: str = "mesh",
    scale: float = 1.0,
    panels: int = PANELS,
    drawn: bool = False,
    rigid: bool = False,
) -> Wetted:
    """Return the surface of a link that water touches.

    Args:
        robot: The robot.
        link: The link's name.
        how: `mesh` for its shapes, joined where they overlap, and wrapped where they
            bound no solid; `hull` for their convex hull; `box` for the box of the
            volume, centre and spread of its solid.
        scale: Factor on all lengths, about the link's origin.
        panels: About how many triangles it is to have.
        drawn: Whether to take the shapes that are only drawn.
        rigid: Whether to take with it the links that cannot move against it.

    Raises:
        RobotError: There is no such link, it has no shape, its shapes enclose nothing,
            the scale is not a positive number, or `how` is unknown.
    """
    where = f"link {link} of robot {robot.name}"
    if not (math.isfinite(scale) and scale > 0):
        raise RobotError(
            f"its wetted shape has the scale {scale:g}",
            where=where,
            fix="give a scale above 0; 1 for shapes in metres, 0.001 for millimetres",
        )
    shapes = shapes_of(robot, link, drawn=drawn, rigid=rigid)
    scaled = tuple(shape.scaled(scale) for shape in shapes)
    return surface(scaled, how=how, panels=panels, where=where)


def surface(
    shapes: tuple[Mesh, ...],
    *,
    how: str = "mesh",
    panels: int = PANELS,
    where: str = "the shapes",
) -> Wetted:
    """Return the surface of a body made of shapes that water touches; see `wetted`.

    Args:
        shapes: Triangle meshes in one frame, m; open, torn or inside out if need be.
        how: `mesh`, `hull` or `box`.
        panels: About how many triangles it is to have.
        where: What to call the body in an error.

    Raises:
        RobotError: There is no shape, a corner is not a number, or nothing is enclosed.
    """
    _check(shapes, how, where)
    whole = joined(shapes)
    if whole.mesh is None:
        return _mended(shapes, whole.notes[0], how, panels, where)
    found = _clean(whole.mesh, "; ".join(whole.notes), shapes, how, panels)
    if sound(Mesh(vertices=found.vertices, faces=found.faces)):
        return found
    return _mended(shapes, "its surface crosses or touches itself", how, panels, where)


def _check(shapes: tuple[Mesh, ...], how: str, where: str) -> None:
    if how not in WAYS:
        raise RobotError(
            f"its wetted surface is to be {how!r}", where=where, fix=f"say {', '.join(WAYS)}"
        )
    if not any(len(shape.faces) for shape in shapes):
        raise RobotError(
            "it has no shape for water to touch",
            where=where,
            fix="give it a collision shape, or leave the fluid's effects off this link",
        )
    if not all(np.isfinite(shape.vertices).all() for shape in shapes):
        raise RobotError(
            "a corner of its shapes is not a number", where=where, fix="export the mesh again"
        )


def _clean(solid: Mesh, notes: str, shapes: tuple[Mesh, ...], how: str, panels: int) -> Wetted:
    box = as_box(solid)
    if how == "mesh" or box is not None:
        return _wetted(even(solid, panels), "mesh", notes, box=box)
    if how == "hull":
        hull = _hull(shapes)
        grown = hull.volume / solid.volume - 1.0
        said = f"the hull was asked for; it holds {grown:.1%} more than the solid"
        return _wetted(even(hull, panels), "hull", said)
    box = equivalent_box(solid)
    said = "a box was asked for: of the solid's volume, centre and spread"
    return _wetted(even(box.mesh, panels), "box", said, box=box)


def _mended(shapes: tuple[Mesh, ...], fault: str, how: str, panels: int, where: str) -> Wetted:
    """Return what stands for shapes that bound no solid, and how much rests on the choice."""
    try:
        hull = _hull(shapes)
    except MeshError as error:
        raise RobotError(
            f"its shapes enclose nothing: {fault}, all in one plane",
            where=where,
            fix="give the plate its thickness, or a box in its place",
        ) from error
    radius = sealing_radius(shapes)
    tried: list[tuple[str, Callable[[], Mesh | None]]] = [
        ("wrap", lambda: wrapped(shapes, cells=CELLS[0], radius=radius, panels=panels)),
        ("wrap, coarser", lambda: wrapped(shapes, cells=CELLS[1], radius=radius, panels=FEW)),
        ("hull", lambda: even(hull, panels)),
    ]
    made = {name: make() for name, make in tried}
    found = {
        name: mesh
        for name, mesh in made.items()
        if mesh is not None and (name == "hull" or sound(mesh))
    }
    box = equivalent_box(found.get("wrap", hull))
    found["box"] = even(box.mesh, panels)
    chosen = how if how != "mesh" else ("wrap" if "wrap" in found else "hull")
    choices = tuple(_choice(name, mesh) for name, mesh in found.items())
    return _wetted(
        found[chosen],
        "wrap" if chosen == "wrap" else ("hull" if chosen == "hull" else "box"),
        _story(shapes, fault, chosen, radius, found),
        box=box if chosen == "box" else None,
        choices=choices,
        spread=_spread(choices, chosen),
    )


def _story(
    shapes: tuple[Mesh, ...], fault: str, chosen: str, radius: float, found: dict[str, Mesh]
) -> str:
    own = sum(shape.volume for shape in shapes)
    words = {
        "wrap": "wrapped watertight",
        "hull": "replaced by the convex hull"
        + ("" if "wrap" in found else ", as a wrap of it encloses nothing"),
        "box": "replaced by a box",
    }
    said = f"{fault}: {words[chosen]}"
    if chosen == "wrap" and radius > 0:
        said += f", with openings up to {2.0 * radius:.3g} m sealed"
    volume = found[chosen].volume
    return f"{said}; it holds {1e3 * volume:.4g} litres, its faces add up to {1e3 * own:.4g}"


def _choice(how: str, mesh: Mesh) -> Choice:
    from morph.physics.fluid.tensor import kirchhoff

    few = even(mesh, FEW)
    tensor = kirchhoff(few.vertices - few.com, few.faces)
    return Choice(how=how, volume=mesh.volume, added=np.diag(tensor).copy())


def _spread(choices: tuple[Choice, ...], chosen: str) -> Array:
    every = np.stack([choice.added for choice in choices])
    own = next(choice.added for choice in choices if choice.how == chosen)
    spread: Array = (every.max(axis=0) - every.min(axis=0)) / own
    return spread


def _hull(shapes: tuple[Mesh, ...]) -> Mesh:
    """Return the convex hull of shapes; that of a fine mesh without its finest facets."""
    shift = np.cumsum([0] + [len(shape.vertices) for shape in shapes])
    hull = Mesh(
        vertices=np.concatenate([shape.vertices for shape in shapes]),
        faces=np.concatenate([s.faces + n for s, n in zip(shapes, shift, strict=False)]),
    ).hull
    if len(hull.faces) <= FEW:
        return hull
    size = float(np.linalg.norm(hull.bounds[1] - hull.bounds[0]))
    simple = from_manifold(as_manifold(hull).simplify(FACET * size)).hull
    grown = (hull.volume / simple.volume) ** (1.0 / 3.0)
    return Mesh(vertices=hull.com + grown * (simple.vertices - simple.com), faces=simple.faces)


def _wetted(
    mesh: Mesh,
    how: How,
    reason: str,
    *,
    box: Box | None = None,
    choices: tuple[Choice, ...] = (),
    spread: Array | None = None,
) -> Wetted:
    return Wetted(
        vertices=mesh.vertices,
        faces=mesh.faces,
        volume=mesh.volume,
        centre=mesh.com,
        how=how,
        reason=reason,
        spread=spread,
        choices=choices,
        box=box,
    )
