"""Drag by panels and by boxes, against plates and balls by hand."""

import math

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.errors import RobotError
from morph.physics.fluid.wetted import box_drag, panel_drag, slow_drag
from morph.physics.fluid.wetted.tessellate import box_mesh, quartered


def fine(mesh: Mesh) -> Mesh:
    vertices, faces = mesh.vertices, mesh.faces
    for _ in range(4):
        vertices, faces = quartered(vertices, faces)
    return Mesh(vertices=vertices, faces=faces)


def test_a_plate_broadside_has_half_c_times_its_area() -> None:
    plate = box_mesh(np.array([0.2, 0.1, 1e-4]))
    drag = panel_drag(plate.vertices, plate.faces, coefficient=1.2)
    assert drag[2] == pytest.approx(0.5 * 1.2 * 0.2 * 0.1, rel=1e-12)


def test_a_plate_that_turns_about_its_edge_has_an_eighth_c_b_l4() -> None:
    plate = box_mesh(np.array([0.2, 0.1, 1e-6]))
    drag = panel_drag(plate.vertices, plate.faces, coefficient=1.2, point=(-0.1, 0.0, 0.0))
    # Integral of r * 1/2 C (w r)^2 b dr from 0 to L; the edge's thickness adds (1e-6 / 0.2)^3.
    assert drag[4] == pytest.approx(1.2 * 0.1 * 0.2**4 / 8, rel=1e-9)


def test_a_ball_has_half_the_drag_of_its_disc(ball: Mesh) -> None:
    drag = panel_drag(ball.vertices, ball.faces, coefficient=1.0)
    # Newton: integral of cos^3 over the front is pi r^2 / 2. 1280 faces of a ball of the
    # same volume have 0.5 % more area, and their normals average what the ball has.
    assert np.allclose(drag[:3], 0.5 * math.pi * 0.01 / 2, rtol=0.01)
    # A ball that turns moves no water by pressure: r x n is below (1 - cos(edge)) r.
    assert (drag[3:] < 1e-4 * 0.1**5).all()


def test_a_box_by_panels_is_the_box_by_formula() -> None:
    sides = np.array([0.64, 0.21, 0.12])
    mesh = fine(box_mesh(sides))
    found = panel_drag(mesh.vertices, mesh.faces, coefficient=1.1)
    # |z|^3 has a kink that panels of 1/16 of a side cut: an error of the order of (1/16)^4 each.
    assert np.allclose(found, box_drag(sides, (1.1, 1.1, 1.1)), rtol=1e-4)


def test_the_drag_of_the_aqua_hull_is_georgiades_formula() -> None:
    drag = box_drag((0.64, 0.21, 0.12), (0.9, 1.08, 1.28))
    # 1/2 C A along, and a (Cy c^4 + Cz b^4) / 64 about x, by hand.
    assert drag[2] == pytest.approx(0.5 * 1.28 * 0.64 * 0.21)
    assert drag[3] == pytest.approx(0.64 * (1.08 * 0.12**4 + 1.28 * 0.21**4) / 64)


def test_drag_grows_with_the_square_and_the_fifth_power_of_size(cube: Mesh) -> None:
    one = panel_drag(cube.vertices, cube.faces)
    two = panel_drag(2 * cube.vertices, cube.faces)
    assert np.allclose(two / one, [4.0] * 3 + [32.0] * 3)


def test_slow_drag_is_stokes_of_the_ball() -> None:
    drag = slow_drag(4 / 3 * math.pi * 1e-3, viscosity=2e-3)
    assert drag[0] == pytest.approx(6 * math.pi * 2e-3 * 0.1)
    assert drag[5] == pytest.approx(8 * math.pi * 2e-3 * 0.1**3)


@pytest.mark.parametrize("bad", [-1.0, math.nan, math.inf])
def test_a_coefficient_that_is_no_drag_is_refused(cube: Mesh, bad: float) -> None:
    with pytest.raises(RobotError, match="the coefficient is"):
        panel_drag(cube.vertices, cube.faces, coefficient=bad)
    with pytest.raises(RobotError, match="the coefficient is"):
        box_drag((1.0, 1.0, 1.0), (1.0, bad, 1.0))
    with pytest.raises(RobotError, match="its sides are"):
        box_drag((1.0, bad if bad < 0 else math.nan, 1.0))
