"""A part under examination, and the rays that several checks look at."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from print.arrays import Array
from print.errors import SolidError
from print.mesh import Mesh
from print.part import Check, Part
from print.printer import Profile
from print.samples import Samples, samples

RAYS = 1500
"""Points of the surface from which rays are cast."""
SKIN_MM = 1e-3
"""How far from the surface a ray starts."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Rays:
    """What rays meet that leave a surface along its normals, inward or outward."""

    samples: Samples
    """Where they start."""
    first_mm: Array
    """How far each goes before it meets the surface; infinite if it does not, shape (n,)."""
    opposed: Array
    """Cosine between ray and outward normal where it leaves: 1 is antiparallel, shape (n,)."""
    depth: Array
    """In how many solids it starts: walls left by it less walls entered, shape (n,)."""


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
    def inward(self) -> Rays:
        """Rays from just inside its surface."""
        return self._cast(-1.0)

    @cached_property
    def outward(self) -> Rays:
        """Rays from just outside its surface."""
        return self._cast(1.0)

    @cached_property
    def pieces(self) -> tuple[Mesh, ...]:
        """Its closed shells, the largest first; the shell of a void is inside out."""
        shells = self.mesh.manifold.decompose()
        if len(shells) == 1:
            return (self.mesh,)
        # Straight from the surface: what is thinner than a rounding error is a shell too.
        found = [shell.to_mesh64() for shell in shells if not shell.is_empty()]
        meshes = [
            Mesh(
                vertices=np.array(each.vert_properties[:, :3], dtype=np.float64),
                faces=np.array(each.tri_verts, dtype=np.int64),
            )
            for each in found
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

    def _cast(self, sign: float) -> Rays:
        surface, solid = self.surface, self.mesh.manifold
        reach = 1.1 * float(np.linalg.norm(self.mesh.extent)) + 1.0
        starts = surface.points + sign * SKIN_MM * surface.normals
        ends = starts + sign * reach * surface.normals
        first = np.full(len(starts), np.inf)
        opposed, depth = np.zeros(len(starts)), np.zeros(len(starts))
        for at, (start, end) in enumerate(zip(starts, ends, strict=True)):
            hits = solid.ray_cast(start, end)
            if not hits:
                continue
            facing = np.array([hit.normal for hit in hits]) @ (sign * surface.normals[at])
            first[at], opposed[at] = hits[0].distance * reach + SKIN_MM, facing[0]
            depth[at] = np.sign(facing).sum()
        return Rays(samples=surface, first_mm=first, opposed=opposed, depth=depth)
