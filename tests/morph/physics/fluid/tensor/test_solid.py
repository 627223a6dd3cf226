"""Tensors of solids with any number of faces, and that they are computed once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.errors import RobotError
from morph.physics.fluid.tensor import box_tensor, ellipsoid_tensor, tensor_of_solid
from morph.physics.fluid.tensor.levels import levels, order_of
from morph.physics.fluid.tensor.solid import positive

Shape = tuple[np.ndarray, np.ndarray]
Ball = Callable[[int], Shape]
AXES = np.array((0.3, 0.2, 0.1))


def test_a_fine_ellipsoid_off_the_origin_has_lambs_tensor(ball: Ball) -> None:
    vertices, faces = ball(5)
    place = np.array((0.4, -0.1, 0.2))
    found = tensor_of_solid(vertices * AXES + place, faces)
    exact = ellipsoid_tensor(*AXES)
    assert found.centre == pytest.approx(place, abs=1e-9)
    # 20480 faces inscribed lack 0.05 % of the volume.
    assert found.volume == pytest.approx(exact.volume, rel=1e-3)
    own, expected = found.about(place).matrix, np.diag(exact.matrix)
    # Two irregular meshes are no clean sequence: extrapolation leaves some tenths of the
    # 2 % along and 4 % about by which they differ.
    assert np.diag(own)[:3] == pytest.approx(expected[:3], rel=0.007)
    assert np.diag(own)[3:] == pytest.approx(expected[3:], rel=0.014)
    assert 1000 < found.panels <= 1400
    worst = np.abs(np.diag(own) / expected - 1).max()
    assert worst < found.error < 0.03


def test_a_mesh_that_is_coarse_enough_is_used_as_it_is(ball: Ball) -> None:
    # Of 320 panels, about the wanted number, the polyhedron's own volume is displaced:
    # 3.4 % less than the ball's. So its added mass is less by that, to within the 2 % of one level.
    vertices, faces = ball(2)
    found = tensor_of_solid(vertices, faces, panels=320, extrapolate=False)
    assert found.panels == 320
    assert found.matrix[0, 0] == pytest.approx(0.5 * found.volume, rel=0.02)


def test_a_cube_of_twelve_faces_comes_near_the_graded_box(cube: Shape) -> None:
    found = np.diag(tensor_of_solid(*cube).matrix)
    exact = np.diag(box_tensor(1, 1, 1).matrix)
    assert found[:3] == pytest.approx(exact[:3], rel=0.01)
    assert found[3:] == pytest.approx(exact[3:], rel=0.03)


def test_the_error_of_a_thin_plate_is_owned_up_to(cube: Shape) -> None:
    sides = np.array((0.16, 0.05, 0.003))
    found = tensor_of_solid(cube[0] * sides, cube[1])
    exact = np.diag(box_tensor(*sides).matrix)
    assert found.error > 0.02
    assert found.matrix[2, 2] == pytest.approx(exact[2], rel=found.error)


def test_a_ball_that_turns_still_meets_a_little_fluid_so_that_the_tensor_is_positive(
    ball: Ball,
) -> None:
    # Extrapolated, the turning of a ball is as likely below zero as above.
    found = tensor_of_solid(*ball(3))
    assert np.linalg.eigvalsh(found.matrix).min() > 0
    assert np.diag(found.matrix)[3:].max() < 1e-3 * found.volume


def test_a_tensor_with_a_motion_that_gains_energy_is_refused() -> None:
    with pytest.raises(RobotError, match=r"-0\.1 times"):
        positive(np.diag((0.5, 0.5, 0.5, 0.1, 0.1, -0.1)), np.ones(6))


def test_edges_that_jut_out_slow_the_error_and_others_do_not(ball: Ball, cube: Shape) -> None:
    # 4/3 where the potential goes as the distance to the power of 2/3; 2 without such a place.
    assert order_of(Mesh(vertices=cube[0], faces=cube[1])) == pytest.approx(4 / 3)
    assert order_of(Mesh(vertices=ball(2)[0], faces=ball(2)[1])) == 2.0


@pytest.mark.parametrize("panels", [320, 1280])
def test_a_solid_is_computed_on_the_panels_asked_for_and_on_a_quarter(
    ball: Ball, panels: int
) -> None:
    vertices, faces = ball(4)
    both = levels(Mesh(vertices=vertices * AXES, faces=faces), panels)
    assert both.coarse is not None
    for level, count in ((both.coarse, panels // 4), (both.fine, panels)):
        assert 0.75 * count <= len(level.mesh.faces) <= 1.4 * count


def test_the_same_solid_gives_the_same_tensor_to_the_last_bit(ball: Ball) -> None:
    vertices, faces = ball(4)
    first = tensor_of_solid(vertices * AXES, faces, panels=320)
    assert (tensor_of_solid(vertices * AXES, faces, panels=320).matrix == first.matrix).all()


@pytest.mark.parametrize("panels", [0, 63, 12_001])
def test_too_few_or_too_many_panels_are_refused(ball: Ball, panels: int) -> None:
    with pytest.raises(RobotError, match=f"panels = {panels}"):
        tensor_of_solid(*ball(1), panels=panels)


def test_a_mesh_that_is_inside_out_is_left_to_the_caller_to_turn(ball: Ball) -> None:
    with pytest.raises(RobotError, match="inside out"):
        tensor_of_solid(ball(1)[0], ball(1)[1][:, ::-1])
