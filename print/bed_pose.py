"""Pose of a part on the print bed, and its constraints."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from morph.print.arrays import Array
from morph.print.errors import SlicerError
from morph.print.mesh import Mesh
from morph.print.part import Part
from morph.print.printer import Profile
from morph.print.settings import SLIM


def laid(mesh: Mesh, turn: Array, profile: Profile) -> Array:
    """Return the pose, shape (4, 4), mm, that lays a turned part on the middle of the bed."""
    pose = np.eye(4)
    pose[:3, :3] = turn
    low, high = mesh.moved(pose).bounds
    width, depth, _ = profile.printer.bed_mm
    pose[:3, 3] = np.array([width / 2.0, depth / 2.0, 0.0]) - [*((low + high) / 2.0)[:2], low[2]]
    return pose


def back(pose: Array) -> Array:
    """Return the pose that undoes one that neither stretches nor shears."""
    undone = np.eye(4)
    undone[:3, :3] = pose[:3, :3].T
    undone[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return undone


def mesh_of(part: Part) -> Mesh:
    """Return the mesh of a part.

    Raises:
        SlicerError: It has none.
    """
    if part.mesh is None:
        raise SlicerError(
            "it has no mesh", where=part.name, fix="slice only parts that are printed"
        )
    return part.mesh


def on_bed(meshes: Mapping[str, Mesh], profile: Profile) -> None:
    """Refuse what is off the bed: PrusaSlicer without a screen prints it without a word."""
    bed = np.array(profile.printer.bed_mm)
    for name, mesh in meshes.items():
        low, high = mesh.bounds
        if (low < -0.01).any() or (high > bed + 0.01).any():
            size = " x ".join(f"{each:.1f}" for each in mesh.extent)
            raise SlicerError(
                f"it ({size} mm) lies from ({low[0]:.1f}, {low[1]:.1f}, {low[2]:.1f}) to "
                f"({high[0]:.1f}, {high[1]:.1f}, {high[2]:.1f}) mm, off the bed of "
                f"{profile.printer.title} ({bed[0]:g} x {bed[1]:g} x {bed[2]:g} mm)",
                where=name,
                fix="cut or turn the part so that it fits, or name a larger printer",
            )


def edge_room(meshes: Mapping[str, Mesh], profile: Profile) -> float:
    """Return the least distance from what is printed to an edge of the bed, mm."""
    low = np.min([mesh.bounds[0] for mesh in meshes.values()], axis=0)
    high = np.max([mesh.bounds[1] for mesh in meshes.values()], axis=0)
    return float(min(low[:2].min(), (np.array(profile.printer.bed_mm) - high)[:2].min()))


def slim(mesh: Mesh) -> bool:
    """Return whether it stands too high to stand safely on its foot alone."""
    return bool(mesh.extent[2] > SLIM * mesh.extent[:2].min())
