"""What tests of print share: a slicer, where there is one, and simple parts."""

from __future__ import annotations

import os
from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from morph.print.job import Orientation
from morph.print.mesh import Mesh
from morph.print.part import Part
from morph.print.printer import Profile, material, printer
from morph.print.slicer import PROGRAMS, Slicer, find_slicer


@pytest.fixture(scope="session")
def slicer() -> Slicer:
    """The PrusaSlicer of the system; CI must have it, elsewhere its tests are skipped."""
    found = find_slicer()
    if found is not None:
        return found
    reason = f"there is no slicer ({', '.join(PROGRAMS)}); `make test` installs one as root"
    if os.environ.get("CI") == "true":
        pytest.fail(reason)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def pla() -> Profile:
    """Fifteen per cent infill in PLA on a bed of 250 x 210 mm."""
    return Profile(printer=printer("mk4"), material=material("pla"))


@pytest.fixture(scope="session")
def upright() -> Orientation:
    """A part lies as its mesh does."""
    return Orientation(turn=np.eye(3), support_mm3=0.0, first_support_mm3=0.0, height_mm=0.0)


@pytest.fixture(scope="session")
def part() -> Callable[[trimesh.Trimesh], Part]:
    """Make a part of one solid."""

    def made(solid: trimesh.Trimesh) -> Part:
        mesh = Mesh(vertices=np.array(solid.vertices), faces=np.array(solid.faces))
        return Part(name="sample", kind="printed", mesh=mesh, placements=())

    return made
