"""Shapes known by name become meshes of exactly their volume."""

import math

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.tessellate import (
    box_mesh,
    capsule_mesh,
    cylinder_mesh,
    ellipsoid_mesh,
)

EVERY = [
    (box_mesh(np.array([1.0, 2.0, 3.0])), 6.0),
    (ellipsoid_mesh(np.array([1.0, 2.0, 3.0])), 4 / 3 * math.pi * 6.0),
    (cylinder_mesh(0.5, 2.0), math.pi * 0.25 * 2.0),
    (capsule_mesh(0.5, 2.0), math.pi * 0.25 * (2.0 + 4 / 3 * 0.5)),
]


@pytest.mark.parametrize(("mesh", "volume"), EVERY)
def test_a_shape_is_closed_faces_outward_and_has_its_exact_volume(
    mesh: Mesh, volume: float
) -> None:
    assert mesh.consistent
    # The polygons are grown to the volume; 1e-12 is rounding over 2000 faces.
    assert mesh.volume == pytest.approx(volume, rel=1e-12)
    assert np.allclose(mesh.com, 0.0, atol=1e-12)


def test_the_volumes_spread_is_that_of_the_true_cylinder() -> None:
    mesh = cylinder_mesh(0.5, 2.0)
    # m (3 r^2 + l^2) / 12 across; a polygon of 32 corners and equal area has r^2 (2 pi/32)^4/45
    # more of second moment, 3e-5 of it.
    across = mesh.volume * (3 * 0.25 + 4.0) / 12
    assert mesh.inertia[0, 0] == pytest.approx(across, rel=1e-4)
