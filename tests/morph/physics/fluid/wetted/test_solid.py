"""Triangles become one solid, or the reason why they bound none."""

import numpy as np
import pytest

from morph.body.mesh import Mesh
from morph.physics.fluid.wetted.solid import joined, winding


def moved(mesh: Mesh, offset: float, size: float = 1.0) -> Mesh:
    return Mesh(vertices=mesh.vertices * size + offset, faces=mesh.faces)


def inverted(mesh: Mesh) -> Mesh:
    return Mesh(vertices=mesh.vertices, faces=mesh.faces[:, ::-1].copy())


def in_one_file(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        vertices=np.concatenate([mesh.vertices for mesh in meshes]),
        faces=np.concatenate([m.faces + s for m, s in zip(meshes, starts, strict=False)]),
    )


def volume_of(*shapes: Mesh) -> float:
    found = joined(shapes).mesh
    assert found is not None
    assert found.consistent
    return found.volume


def test_what_overlaps_is_counted_once(cube: Mesh) -> None:
    # Two cubes of 0.1 m, shifted by 0.05 m along each axis: 2 - 1/8 of a cube.
    assert volume_of(cube, moved(cube, 0.05)) == pytest.approx(1.875e-3, rel=1e-9)
    assert volume_of(in_one_file(cube, moved(cube, 0.05))) == pytest.approx(1.875e-3, rel=1e-9)


def test_solids_apart_stay_two(cube: Mesh) -> None:
    assert volume_of(in_one_file(cube, moved(cube, 1.0))) == pytest.approx(2e-3, rel=1e-9)


def test_a_mesh_that_is_inside_out_is_turned_and_said_to_be(cube: Mesh) -> None:
    found = joined((inverted(cube),))
    assert found.mesh is not None
    assert found.mesh.volume == pytest.approx(1e-3)
    assert found.notes == ("1 of 1 pieces were inside out and were turned",)


def test_a_hollow_is_filled_as_no_water_gets_in(cube: Mesh) -> None:
    assert volume_of(in_one_file(cube, inverted(moved(cube, 0.0, 0.5)))) == pytest.approx(1e-3)


def test_an_open_piece_is_counted_among_the_pieces(cube: Mesh) -> None:
    torn = Mesh(vertices=cube.vertices, faces=cube.faces[1:])
    found = joined((in_one_file(moved(cube, 1.0), torn),))
    assert found.mesh is None
    assert found.notes == ("1 open of its 2 pieces",)


def test_a_sheet_with_two_sides_encloses_nothing(cube: Mesh) -> None:
    flat = Mesh(vertices=cube.vertices * np.array([1.0, 1.0, 0.0]), faces=cube.faces)
    assert joined((flat,)).mesh is None


def test_faces_that_stand_twice_or_have_no_area_do_no_harm(cube: Mesh) -> None:
    extra = np.concatenate([cube.faces, cube.faces[:2], [[0, 0, 1]]])
    assert volume_of(Mesh(vertices=cube.vertices, faces=extra)) == pytest.approx(1e-3)


def test_a_closed_surface_winds_once_around_what_is_inside(cube: Mesh) -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.04, 0.04, -0.04], [0.06, 0.0, 0.0]])
    assert np.allclose(winding(points, cube), (1.0, 1.0, 0.0), atol=1e-12)
