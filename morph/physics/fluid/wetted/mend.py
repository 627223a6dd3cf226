"""What stands for shapes that bound no solid: a wrap, a hull or a box."""

from __future__ import annotations

import numpy as np

from morph.arrays import Array
from morph.body.mesh import Mesh
from morph.errors import MeshError, RobotError
from morph.physics.fluid.tensor import tensor_of_solid
from morph.physics.fluid.tensor.manifold import simplified
from morph.physics.fluid.wetted.box import equivalent_box
from morph.physics.fluid.wetted.outcome import How, SurfaceChoice, Wetted, wetted_by
from morph.physics.fluid.wetted.sound import sound
from morph.physics.fluid.wetted.wrap import sealing_radius, wrapped

PANELS, FEW = 1280, 400
"""Panels of a wrap, and of what is only compared."""

CELLS = (96, 48)
"""Points along the greatest extent when wrapping; the first is used, both are compared."""

FACET = 1e-3
"""How far the hull of a fine mesh may be off, as a part of its diagonal."""


def mended(
    shapes: tuple[Mesh, ...], fault: str, *, how: str = "mesh", where: str = "the shapes"
) -> Wetted:
    """Return what stands for shapes that bound no solid, and how much rests on the choice.

    Args:
        shapes: Triangle meshes in one frame, m.
        fault: What is wrong with them.
        how: `mesh` for a wrap, or for the hull where none is found; `hull` or `box`.
        where: What to call the body in an error.

    Raises:
        RobotError: They enclose nothing.
    """
    try:
        hull = hull_of(shapes)
    except MeshError as error:
        raise RobotError(
            f"its shapes enclose nothing: {fault}, all in one plane",
            where=where,
            fix="give the plate its thickness, or a box in its place",
        ) from error
    radius = sealing_radius(shapes)
    results = {"hull": hull}
    for name, cells, panels in (("wrap", CELLS[0], PANELS), ("wrap, coarser", CELLS[1], FEW)):
        skin = wrapped(shapes, cells=cells, radius=radius, panels=panels)
        if skin is not None and sound(skin):
            results[name] = skin
    box = equivalent_box(results.get("wrap", hull))
    results["box"] = box.mesh
    chosen: How = "hull"
    if how == "box" or (how == "mesh" and "wrap" in results):
        chosen = "box" if how == "box" else "wrap"
    choices = tuple(filter(None, (_choice(name, mesh) for name, mesh in results.items())))
    return wetted_by(
        results[chosen],
        chosen,
        _story(shapes, fault, chosen, radius, results),
        box=box if chosen == "box" else None,
        choices=choices,
        spread=_spread(choices, chosen),
    )


def _story(
    shapes: tuple[Mesh, ...], fault: str, chosen: str, radius: float, results: dict[str, Mesh]
) -> str:
    own = sum(shape.volume for shape in shapes)
    words = {
        "wrap": "wrapped watertight",
        "hull": "replaced by the convex hull"
        + ("" if "wrap" in results else ", as a wrap of it encloses nothing"),
        "box": "replaced by a box",
    }
    text = f"{fault}: {words[chosen]}"
    if chosen == "wrap" and radius > 0:
        text += f", with openings up to {2.0 * radius:.3g} m sealed"
    volume = results[chosen].volume
    return f"{text}; it holds {1e3 * volume:.4g} litres, its faces add up to {1e3 * own:.4g}"


def _choice(how: str, mesh: Mesh) -> SurfaceChoice | None:
    """Return what a surface would mean; None if boundary elements refuse it."""
    try:
        tensor = tensor_of_solid(mesh.vertices, mesh.faces, panels=FEW, extrapolate=False)
    except RobotError:
        return None
    return SurfaceChoice(
        how=how, volume=mesh.volume, added=np.diag(tensor.about(tensor.centre).matrix)
    )


def _spread(choices: tuple[SurfaceChoice, ...], chosen: str) -> Array | None:
    every = {choice.how: choice.added for choice in choices}
    if chosen not in every:
        return None
    added = np.stack(list(every.values()))
    spread: Array = (added.max(axis=0) - added.min(axis=0)) / every[chosen]
    return spread


def hull_of(shapes: tuple[Mesh, ...]) -> Mesh:
    """Return the convex hull of shapes; that of a fine mesh without its finest facets."""
    shift = np.cumsum([0] + [len(shape.vertices) for shape in shapes])
    hull = Mesh(
        vertices=np.concatenate([shape.vertices for shape in shapes]),
        faces=np.concatenate([s.faces + n for s, n in zip(shapes, shift, strict=False)]),
    ).hull
    if len(hull.faces) <= FEW:
        return hull
    size = float(np.linalg.norm(hull.bounds[1] - hull.bounds[0]))
    return of_volume(simplified(hull, FACET * size).hull, hull.volume)


def of_volume(mesh: Mesh, volume: float) -> Mesh:
    """Return a mesh grown about its centre to a volume, m3."""
    grown = (volume / mesh.volume) ** (1.0 / 3.0)
    return Mesh(vertices=mesh.com + grown * (mesh.vertices - mesh.com), faces=mesh.faces)
