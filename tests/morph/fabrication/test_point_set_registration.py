"""Finding the motion that lays one thing on another."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from morph.arrays import Array
from morph.fabrication.moments import laid
from morph.fabrication.point_set_registration import cloud, motion
from morph.fabrication.solids import placed
from morph.print.mesh import Mesh, from_manifold


def turn(rng: np.random.Generator, *, mirrored: bool) -> Array:
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation)) * (-1.0 if mirrored else 1.0)
    return placed(rotation, rng.normal(size=3) * 50.0)


def crooked() -> Mesh:
    """Return a solid without any symmetry: three boxes of different sizes in a corner."""
    boxes = [
        manifold3d.Manifold.cube([30.0, 8.0, 5.0]),
        manifold3d.Manifold.cube([6.0, 20.0, 5.0]),
        manifold3d.Manifold.cube([4.0, 8.0, 14.0]).translate([2.0, 1.0, 0.0]),
    ]
    return from_manifold(manifold3d.Manifold.batch_boolean(boxes, manifold3d.OpType.Add))


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_points_that_were_moved_are_laid_back(seed: int, mirrored: bool) -> None:
    rng = np.random.default_rng(seed)
    mesh, pose = crooked(), turn(rng, mirrored=mirrored)
    moved = mesh.moved(pose).vertices
    found = motion(cloud((0.0, mesh.vertices)), cloud((0.0, rng.permutation(moved))))
    assert found is not None
    # Points match to 0.01 mm over some 30 mm.
    assert found[:3, :3] == pytest.approx(pose[:3, :3], abs=1e-3)
    assert (np.linalg.det(found[:3, :3]) < 0) == mirrored


def test_points_with_other_labels_are_something_else() -> None:
    points = np.random.default_rng(0).normal(size=(20, 3))
    assert motion(cloud((0.0, points)), cloud((1.0, points))) is None


def test_one_corner_moved_by_a_tenth_of_a_millimetre_is_another_part() -> None:
    points = 20.0 * np.random.default_rng(0).normal(size=(20, 3))
    other = points.copy()
    other[7] += [0.1, 0.0, 0.0]
    assert motion(cloud((0.0, points)), cloud((0.0, other))) is None


@pytest.mark.parametrize("mirrored", [False, True])
def test_a_solid_is_found_though_its_triangles_differ(mirrored: bool) -> None:
    mesh, pose = crooked(), turn(np.random.default_rng(4), mirrored=mirrored)
    finer = from_manifold(mesh.manifold.refine(3)).moved(pose)
    assert len(finer.vertices) > len(mesh.vertices)
    found = laid(mesh, finer)
    assert found is not None
    assert found == pytest.approx(pose, abs=1e-6)


def test_a_solid_with_a_hole_more_is_another_part() -> None:
    mesh = crooked()
    hole = manifold3d.Manifold.cylinder(30.0, 1.0, 1.0, 24, True).translate([20.0, 4.0, 0.0])
    assert laid(mesh, from_manifold(mesh.manifold - hole)) is None
