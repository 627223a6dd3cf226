"""From a mesh that is nearly a solid to one that is, or the reason why not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from morph.print import facets
from morph.print.deviation import deviation
from morph.print.edges import trouble
from morph.print.errors import SolidError
from morph.print.mesh import Mesh, from_manifold, joined

VOLUME = 0.01
"""Most that a repair may change the volume, as a part of it."""
DISTANCE_MM = 0.1
"""Furthest that a repair may move the surface: half the height of a layer."""
FIX = "export what is printed alone, without motors and screws, as one closed solid"
"""How to put right what cannot be mended."""


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshRepair:
    """A solid, and what was done to the mesh that was given."""

    mesh: Mesh
    """Closed, wound outward."""
    steps: tuple[str, ...]
    """What was done, in words and in order; empty if nothing had to be."""
    volume_change: float | None
    """By the volume before; None where the mesh that was given encloses none."""
    distance_mm: float
    """Greatest distance between the surfaces before and after."""


def repaired(mesh: Mesh, *, where: str) -> MeshRepair:
    """Return the mesh as a solid, mended as little as it takes.

    In this order, until manifold3d takes it: coinciding corners become one, and those of open
    edges beside each other; double and degenerate faces go, faces are wound alike, flat holes are
    filled. That a mesh is closed afterwards proves nothing, so each repair is held against the
    mesh that was given: by `VOLUME` and `DISTANCE_MM`. Shells that overlap a little are joined
    by the same rule.

    Args:
        mesh: What was given, mm.
        where: The part's name, for errors.

    Raises:
        SolidError: It encloses no solid, or only one that is too far from what was given.
    """
    _refuse_numbers(mesh, where)
    result, steps = _closed(mesh, where)
    if result.volume < 0:
        result, steps = facets.turned(result), (*steps, "turned inside out")
    apart = deviation(mesh, result) if len(steps) else None
    change = apart.volume if apart else 0.0
    distance = apart.distance_mm if apart else 0.0
    if "turned inside out" in steps and change is not None:
        # Turning changes the sign of the volume and nothing else.
        change = abs(abs(result.volume) - abs(mesh.volume)) / abs(result.volume)
    _refuse_far(change, distance, mesh, steps, where)
    whole, overlap = _one_shell(result)
    if whole is not result:
        steps = (*steps, f"joined its shells, which share {100 * overlap:.2g} % of their volume")
    return MeshRepair(
        mesh=whole,
        steps=steps,
        volume_change=None if change is None else max(change, overlap),
        distance_mm=distance,
    )


def _refuse_numbers(mesh: Mesh, where: str) -> None:
    if not len(mesh.faces) or not len(mesh.vertices):
        raise SolidError("the mesh is empty", where=where, fix="export the part again")
    if not np.isfinite(mesh.vertices).all():
        bad = int((~np.isfinite(mesh.vertices)).any(axis=1).sum())
        raise SolidError(
            f"{bad} of its {len(mesh.vertices)} corners are not at finite numbers",
            where=where,
            fix="export the part again",
        )
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise SolidError(
            f"a face names corner {int(mesh.faces.max())}, and there are {len(mesh.vertices)}",
            where=where,
            fix="export the part again",
        )


def _closed(mesh: Mesh, where: str) -> tuple[Mesh, tuple[str, ...]]:
    """Return the first mesh along the ladder that manifold3d takes, and the rungs so far."""
    ladder: tuple[tuple[str, Callable[[Mesh], Mesh]], ...] = (
        ("merged coinciding corners", facets.merged),
        ("closed cracks", facets.without_cracks),
        ("dropped double and degenerate faces", facets.without_doubles),
        ("wound faces alike", facets.wound_alike),
        ("filled flat holes", facets.filled),
        ("closed cracks", facets.without_cracks),
    )
    given, steps, reason = mesh, tuple[str, ...](), _reason(mesh)
    for step, mend in ladder:
        if not reason:
            break
        after = mend(mesh)
        if len(after.faces) == 0:
            raise SolidError(
                "nothing is left of it without double and degenerate faces",
                where=where,
                fix="give the part a thickness, and export it as a solid",
            )
        if len(after.faces) != len(mesh.faces) or not np.array_equal(after.faces, mesh.faces):
            mesh, steps, reason = after, (*steps, step), _reason(after)
    if reason:
        raise SolidError(
            f"it encloses no solid (manifold3d: {reason}): {_defects(given)}", where=where, fix=FIX
        )
    return mesh, steps


def _reason(mesh: Mesh) -> str:
    """Return manifold3d's name of what is wrong; empty if nothing is."""
    try:
        _ = mesh.manifold
    except SolidError as error:
        return error.what.rpartition("(")[2].rstrip(")")
    return ""


def _refuse_far(
    change: float | None, distance: float, given: Mesh, steps: tuple[str, ...], where: str
) -> None:
    by = ""
    if change is not None and change > VOLUME:
        by = f"change its volume by {100 * change:.1f} %, and {100 * VOLUME:.0f} % is allowed"
    if distance > DISTANCE_MM:
        by = f"move its surface by {distance:.2g} mm, and {DISTANCE_MM} mm is allowed"
    if by:
        raise SolidError(
            f"it encloses no solid: {_defects(given)}; a repair ({', '.join(steps)}) would {by}",
            where=where,
            fix=FIX,
        )


def _defects(given: Mesh) -> str:
    """Return in words what keeps a mesh from being closed once coinciding corners are one."""
    return trouble(facets.merged(given)) or "faces that meet in corners only"


def _one_shell(mesh: Mesh) -> tuple[Mesh, float]:
    """Return the mesh with its solids joined, if little of it lies in two of them.

    The distance says nothing here: where two solids touch, the faces between them vanish, and
    the solid is the same. What counts is the volume that was counted twice.
    """
    shells = mesh.manifold.decompose()
    # With voids it would have to be known which solid each is in; the checks then say it overlaps.
    if len(shells) < 2 or any(shell.volume() <= 0 for shell in shells):
        return mesh, 0.0
    whole = joined(map(from_manifold, shells))
    overlap = sum(shell.volume() for shell in shells) / whole.volume - 1.0
    if overlap > VOLUME or len(whole.manifold.decompose()) == len(shells):
        return mesh, 0.0
    return whole, max(overlap, 0.0)
