"""Which surface of a link water touches: its own solid, a wrap, a hull or a box, and why."""

from __future__ import annotations

import math

import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.body.robot import Robot
from morph.errors import RobotError
from morph.physics.fluid.wetted.box import as_box, equivalent_box
from morph.physics.fluid.wetted.mend import hull_of, mended, of_volume
from morph.physics.fluid.wetted.outcome import Wetted, wetted_by
from morph.physics.fluid.wetted.shapes import shapes_of
from morph.physics.fluid.wetted.solid import joined
from morph.physics.fluid.wetted.sound import sound

WAYS = ("mesh", "hull", "box")
"""What may be asked for; a mesh that bounds no solid is wrapped."""

TOUCH = 1e-3
"""By how much parts that touch are grown to overlap, as a part of the whole's diagonal."""


def wetted(
    robot: Robot,
    link: str,
    *,
    how: str = "mesh",
    scale: float = 1.0,
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
    return surface(scaled, how=how, where=where)


def surface(shapes: tuple[Mesh, ...], *, how: str = "mesh", where: str = "the shapes") -> Wetted:
    """Return the surface of a body made of shapes that water touches; see `wetted`.

    Args:
        shapes: Triangle meshes in one frame, m; open, torn or inside out if need be.
        how: `mesh`, `hull` or `box`.
        where: What to call the body in an error.

    Raises:
        RobotError: There is no shape, a corner is not a number, or nothing is enclosed.
    """
    check_shapes(shapes, how, where)
    whole = joined(shapes)
    if whole.mesh is None:
        return mended(shapes, whole.notes[0], how=how, where=where)
    # A box is sound, however thin.
    if as_box(whole.mesh) is not None or sound(whole.mesh):
        return _clean(whole.mesh, "; ".join(whole.notes), shapes, how)
    length = TOUCH * float(np.linalg.norm(np.ptp(_bounds(shapes), axis=0)))
    overlapping = joined(shapes, grown=length).mesh if len(shapes) > 1 else None
    if overlapping is not None and sound(overlapping):
        text = f"parts that only touch were grown by {length:.1g} m to be one"
        notes = "; ".join((*whole.notes, text))
        return _clean(of_volume(overlapping, whole.mesh.volume), notes, shapes, how)
    return mended(shapes, "its surface crosses or touches itself", how=how, where=where)


def check_shapes(shapes: tuple[Mesh, ...], how: str, where: str) -> None:
    """Check that there are shapes, of numbers, and that the surface asked for is known.

    Raises:
        RobotError: There are none, or one of them is not.
    """
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


def _clean(solid: Mesh, notes: str, shapes: tuple[Mesh, ...], how: str) -> Wetted:
    box = as_box(solid)
    if how == "mesh" or box is not None:
        return wetted_by(solid, "mesh", notes, box=box)
    if how == "hull":
        hull = hull_of(shapes)
        grown = hull.volume / solid.volume - 1.0
        text = f"the hull was asked for; it holds {grown:.1%} more than the solid"
        return wetted_by(hull, "hull", text)
    box = equivalent_box(solid)
    text = "a box was asked for: of the solid's volume, centre and spread"
    return wetted_by(box.mesh, "box", text, box=box)


def _bounds(shapes: tuple[Mesh, ...]) -> Array:
    return np.concatenate([shape.bounds for shape in shapes if len(shape.faces)])
