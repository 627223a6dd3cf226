"""Shapes and profiles that the checks are tried on."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
import trimesh

from morph.print.check.subject import Subject
from morph.print.mesh import Mesh
from morph.print.part import Part, Placement, Seat
from morph.print.printer import Profile, material, printer


@pytest.fixture
def profile() -> Profile:
    return Profile(printer=printer("ender3"), material=material("pla"))


@pytest.fixture
def box() -> Callable[..., Mesh]:
    """Return a box by its sides, mm, about a point."""

    def made(*sides: float, at: Sequence[float] = (0.0, 0.0, 0.0)) -> Mesh:
        found = trimesh.creation.box(sides)
        return Mesh(
            vertices=np.array(found.vertices) + at, faces=np.array(found.faces, dtype=np.int64)
        )

    return made


@pytest.fixture
def beside() -> Callable[..., Mesh]:
    """Return meshes as one, nothing merged or joined."""

    def made(*meshes: Mesh) -> Mesh:
        found = trimesh.util.concatenate([mesh.trimesh for mesh in meshes])
        return Mesh(vertices=np.array(found.vertices), faces=np.array(found.faces, dtype=np.int64))

    return made


@pytest.fixture
def part() -> Callable[..., Part]:
    """Return a printed part of a mesh."""

    def made(mesh: Mesh | None, *seats: Seat) -> Part:
        here = Placement(link="link", pose=np.eye(4), world=np.eye(4))
        return Part(name="part", kind="printed", mesh=mesh, placements=(here,), seats=seats)

    return made


@pytest.fixture
def subject(part: Callable[..., Part], profile: Profile) -> Callable[..., Subject]:
    """Return a part of a mesh under examination."""

    def made(mesh: Mesh | None, *seats: Seat) -> Subject:
        return Subject(part=part(mesh, *seats), profile=profile)

    return made
