"""The box that stands for a solid."""

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.box import as_box, equivalent_box
from morph.physics.fluid.wetted.tessellate import box_mesh, ellipsoid_mesh

C, S = np.cos(0.3), np.sin(0.3)
TURN = np.array([[C, -S, 0.0], [S, C, 0.0], [0.0, 0.0, 1.0]])


def test_the_box_of_a_turned_box_is_that_box() -> None:
    mesh = box_mesh(np.array([0.16, 0.05, 0.003]))
    turned = Mesh(vertices=mesh.vertices @ TURN.T + 1.0, faces=mesh.faces)
    box = as_box(turned)
    assert box is not None
    assert np.allclose(box.sides, (0.16, 0.05, 0.003), rtol=1e-9)
    assert np.allclose(box.axes, TURN, atol=1e-9)
    assert np.allclose(box.centre, 1.0)


def test_the_box_of_a_ball_has_its_volume_and_equal_sides(ball: Mesh) -> None:
    box = equivalent_box(ball)
    # An icosahedron's symmetry makes all second moments equal.
    assert np.allclose(box.sides, ball.volume ** (1 / 3), rtol=1e-9)
    assert as_box(ball) is None


def test_the_boxes_axes_are_a_rotation_whatever_the_solid() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        mesh = ellipsoid_mesh(np.array([0.3, 0.2, 0.1]))
        box = equivalent_box(Mesh(vertices=mesh.vertices @ turn.T, faces=mesh.faces))
        assert np.linalg.det(box.axes) == pytest.approx(1.0)
        assert np.allclose(np.sort(box.sides)[::-1] / box.sides.max(), (1, 2 / 3, 1 / 3))
        assert box.mesh.consistent
        assert box.mesh.volume == pytest.approx(mesh.volume)
