"""Even triangles of the same solid."""

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.physics.fluid.tensor.remesh import evenness, remeshed
from morph.physics.fluid.wetted.sound import sound
from morph.physics.fluid.wetted.tessellate import (
    box_mesh,
    cylinder_mesh,
    ellipsoid_mesh,
    quartered,
)


def test_a_box_stays_the_box_in_even_triangles() -> None:
    sides = np.array([0.64, 0.21, 0.12])
    mesh = remeshed(box_mesh(sides), 400)
    assert sound(mesh)
    assert 200 < len(mesh.faces) < 800
    assert np.allclose(np.ptp(mesh.vertices, axis=0), sides)
    assert mesh.volume == pytest.approx(sides.prod(), rel=1e-9)
    # The box's own triangles: legs of 0.64 and 0.12 m make 0.31.
    assert evenness(mesh) > 0.7


def test_a_paddle_keeps_its_thickness() -> None:
    mesh = remeshed(box_mesh(np.array([0.16, 0.05, 0.003])), 400)
    assert sound(mesh)
    assert np.allclose(np.ptp(mesh.vertices, axis=0), (0.16, 0.05, 0.003))


def test_slivers_are_gone_and_the_volume_is_not() -> None:
    needles = cylinder_mesh(0.1, 0.02)
    vertices, faces = needles.vertices.copy(), needles.faces
    for _ in range(2):
        vertices, faces = quartered(vertices, faces)
    thin = Mesh(vertices=vertices * np.array([1.0, 0.1, 1.0]), faces=faces)
    mesh = remeshed(thin, 600)
    assert sound(mesh)
    assert mesh.volume == pytest.approx(thin.volume, rel=1e-9)
    assert len(mesh.faces) < len(thin.faces) / 3
    assert evenness(mesh) > 2 * evenness(thin)


def test_a_fine_ball_becomes_a_coarse_one_of_its_volume_and_centre() -> None:
    ball = ellipsoid_mesh(np.full(3, 0.1))
    mesh = remeshed(ball, 320)
    assert sound(mesh)
    assert len(mesh.faces) < 500
    assert mesh.volume == pytest.approx(ball.volume, rel=1e-9)
    # Corners only move onto corners: all lie on the ball, grown by what 320 flat faces lack.
    assert np.linalg.norm(mesh.com) < 0.005 * 0.1


def test_a_surface_that_touches_itself_is_not_sound() -> None:
    cube = box_mesh(np.full(3, 0.1))
    other = cube.vertices + np.array([0.05, 0.02, 0.02])
    both = Mesh(
        vertices=np.concatenate([cube.vertices, other]),
        faces=np.concatenate([cube.faces, cube.faces + 8]),
    )
    assert sound(cube)
    assert not sound(both)
