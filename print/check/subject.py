"""A part under examination, and the points at which several checks look."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from morph.print.arrays import Array
from morph.print.errors import SolidError
from morph.print.mesh import Mesh
from morph.print.part import Check, Part
from morph.print.printer import Profile
from morph.print.samples import Samples, samples

RAYS = 1500
"""Points of the surface at which is looked."""
SKIN_MM = 1e-3
"""How far from the surface a ray starts."""
REACH_MM = 3.0
"""How far walls are felt for."""
TILT = 1.37e-3
"""How much a ray along an axis leans to both sides."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Walls:
    """What is behind each point of a surface: how thick the part is there."""

    thickness_mm: Array
    """From the point inward to where the part ends; infinite beyond `REACH_MM`, shape (n,)."""
    opposed: Array
    """Cosine between that way and the outward normal at its end: 1 is antiparallel, shape (n,)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Subject:
    """One part, repaired if it had to be, with what it is to be printed on."""

    part: Part
    """The part."""
    profile: Profile
    """Printer, material and settings."""

    @property
    def mesh(self) -> Mesh:
        """Its solid.

        Raises:
            SolidError: It has none.
        """
        if self.part.mesh is None:
            raise SolidError(
                "it has no mesh", where=self.part.name, fix="give a mesh of what is printed"
            )
        return self.part.mesh

    @cached_property
    def surface(self) -> Samples:
        """Points over its surface."""
        return samples(self.mesh, RAYS)

    @cached_property
    def walls(self) -> Walls:
        """How thick the part is behind each point of its surface."""
        surface, solid = self.surface, self.mesh.manifold
        starts = surface.points - SKIN_MM * surface.normals
        ends = surface.points - REACH_MM * surface.normals
        thickness = np.full(len(starts), np.inf)
        opposed = np.zeros(len(starts))
        for at, (start, end) in enumerate(zip(starts, ends, strict=True)):
            hits = solid.ray_cast(start, end)
            if hits:
                thickness[at] = SKIN_MM + hits[0].distance * (REACH_MM - SKIN_MM)
                opposed[at] = -surface.normals[at] @ hits[0].normal
        return Walls(thickness_mm=thickness, opposed=opposed)

    def depth(self, sign: float) -> Array:
        """Return in how many solids it is just outside (1) or inside (-1) each point, shape (n,).

        That is the winding number of the surface: along any way out, walls left less walls
        entered. The way taken is nearly along an axis, because manifold3d looks at all triangles
        in the upright box around a ray; not quite, so that it lies in no wall.
        """
        surface, solid = self.surface, self.mesh.manifold
        starts = surface.points + sign * SKIN_MM * surface.normals
        axis = np.abs(surface.normals).argmax(axis=1)
        rows = np.arange(len(starts))
        way = np.full_like(starts, TILT)
        way[rows, axis] = np.sign(surface.normals[rows, axis])
        ends = starts + (self.mesh.extent.max() + 1.0) * way
        result = np.zeros(len(starts))
        for at, (start, end) in enumerate(zip(starts, ends, strict=True)):
            hits = solid.ray_cast(start, end)
            if hits:
                result[at] = np.sign(np.array([hit.normal for hit in hits]) @ way[at]).sum()
        return result

    @cached_property
    def pieces(self) -> tuple[Mesh, ...]:
        """Its closed shells, the largest first; the shell of a void is inside out."""
        shells = self.mesh.manifold.decompose()
        if len(shells) == 1:
            return (self.mesh,)
        # Straight from the surface: what is thinner than a rounding error is a shell too.
        results = [shell.to_mesh64() for shell in shells if not shell.is_empty()]
        meshes = [
            Mesh(
                vertices=np.array(each.vert_properties[:, :3], dtype=np.float64),
                faces=np.array(each.tri_verts, dtype=np.int64),
            )
            for each in results
        ]
        return tuple(sorted(meshes, key=lambda each: -abs(each.volume)))

    def says(
        self,
        name: str,
        verdict: Literal["passed", "noted", "refused"],
        what: str,
        fix: str = "",
        *,
        value: float | None = None,
        limit: float | None = None,
    ) -> Check:
        """Return a check of this part."""
        return Check(
            part=self.part.name,
            name=name,
            verdict=verdict,
            what=what,
            fix=fix,
            value=value,
            limit=limit,
        )
