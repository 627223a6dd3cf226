from __future__ import annotations

import numpy as np
import pytest
import trimesh

from morph.print.errors import SolidError
from morph.print.mesh import Mesh
from morph.print.samples import samples


def mesh_of(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices=np.array(shape.vertices), faces=np.array(shape.faces, dtype=np.int64))


def test_each_side_of_a_box_has_points_by_its_area() -> None:
    found = samples(mesh_of(trimesh.creation.box((10.0, 20.0, 40.0))), 1000)
    # 2 (10*20 + 10*40 + 20*40) = 2800 mm2; the sides across x have 2*20*40 = 1600 of it. Points
    # are strides of area, so each side is right to one point: two sides, 2 of 1000.
    across_x = (np.abs(found.normals[:, 0]) > 0.5).mean()
    assert across_x == pytest.approx(1600 / 2800, abs=0.002)
    assert found.area == pytest.approx(2.8)


def test_points_lie_on_a_ball_where_its_facets_are() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3, radius=10.0)
    found = samples(mesh_of(ball), 500)
    # A second library's distance; rounding alone.
    _, apart, _ = trimesh.proximity.closest_point(ball, found.points)
    assert apart.max() < 1e-9
    # Mean of points spread evenly over a sphere is its centre, to spacing / sqrt(n) or so:
    # sqrt(1257 / 500) = 1.6 mm apart.
    assert np.linalg.norm(found.points.mean(axis=0)) < 0.3


def test_two_runs_give_the_same_points() -> None:
    mesh = mesh_of(trimesh.creation.box((10.0, 20.0, 40.0)))
    assert np.array_equal(samples(mesh, 100).points, samples(mesh, 100).points)


def test_what_has_no_area_has_no_points() -> None:
    flat = Mesh(vertices=np.zeros((3, 3)), faces=np.array([[0, 1, 2]]))
    with pytest.raises(SolidError, match="no area"):
        samples(flat, 10)
