from __future__ import annotations

import manifold3d
import numpy as np
import pytest
import trimesh

from morph.print.arrays import Array
from morph.print.overhang import overhanging, standing
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))


def corners(shape: trimesh.Trimesh) -> Array:
    return np.asarray(shape.vertices)[np.asarray(shape.faces)]


def solid(shape: manifold3d.Manifold) -> Array:
    mesh = shape.to_mesh64()
    return np.asarray(mesh.vert_properties)[np.asarray(mesh.tri_verts)]


def test_a_box_touches_the_bed_with_its_bottom_and_needs_no_support() -> None:
    found = standing(corners(trimesh.creation.box(extents=(30, 20, 10))), PROFILE)
    assert found.support_mm3 == found.supported_mm2 == 0.0
    # Columns count whole or not at all: one row more or less of 0.4 mm on 20 mm is 2 %.
    assert found.contact_mm2 == pytest.approx(600.0, rel=0.02)


def test_a_table_is_supported_down_to_the_bed() -> None:
    # A plate of 40 x 40 on a leg of 10 x 10, 20 high: (1600 - 100) * 20 = 30000 mm3.
    top = manifold3d.Manifold.cube((40, 40, 5)).translate((-20, -20, 20))
    found = standing(
        solid(top + manifold3d.Manifold.cube((10, 10, 20)).translate((-5, -5, 0))), PROFILE
    )
    # Pitch sqrt(1600 / 4000) = 0.63 mm: half a column along 160 + 40 mm of edge is 63 of 1500 mm2.
    assert found.support_mm3 == pytest.approx(30000.0, rel=0.05)
    assert found.supported_mm2 == pytest.approx(1500.0, rel=0.05)
    assert found.contact_mm2 == pytest.approx(100.0, rel=0.2)


def test_a_shelf_is_supported_down_to_what_lies_below_it_only() -> None:
    # Two plates of 40 x 40 x 5 that a wall of 5 joins: 35 * 40 * (30 - 5) = 35000 mm3 between them.
    cube = manifold3d.Manifold.cube
    both = cube((40, 40, 5)) + cube((40, 40, 5)).translate((0, 0, 30)) + cube((5, 40, 35))
    assert standing(solid(both), PROFILE).support_mm3 == pytest.approx(35000.0, rel=0.03)


@pytest.mark.parametrize(("lean_deg", "held"), [(45.0, False), (55.0, True)])
def test_what_leans_less_than_the_profile_says_stands_alone(lean_deg: float, held: bool) -> None:
    # The profile says 50 degrees; a funnel's wall leans by as much as its radius grows.
    assert PROFILE.overhang_deg == 50.0
    wide = 5.0 + 20.0 * np.tan(np.deg2rad(lean_deg))
    funnel = manifold3d.Manifold.cylinder(20.0, 5.0, wide, 64)
    found = standing(solid(funnel), PROFILE)
    # What is under a funnel: the cylinder around it less itself.
    under = np.pi * 20.0 * (wide**2 - (25.0 + 5.0 * wide + wide**2) / 3.0)
    assert found.support_mm3 == pytest.approx(under if held else 0.0, rel=0.03)


def test_a_face_at_the_very_angle_needs_no_support() -> None:
    lean = np.deg2rad(np.array([50.0, 50.1, -90.0, 90.0]))
    normals = np.stack([np.cos(lean), 0.0 * lean, -np.sin(lean)], axis=1)
    assert overhanging(normals, PROFILE).tolist() == [False, True, False, True]
