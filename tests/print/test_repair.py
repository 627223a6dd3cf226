from __future__ import annotations

import numpy as np
import pytest
import trimesh

from morph.print.errors import SolidError
from morph.print.mesh import Mesh
from morph.print.repair import DISTANCE_MM, repaired


def box(*sides: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    found = trimesh.creation.box(sides)
    return Mesh(vertices=np.array(found.vertices) + at, faces=np.array(found.faces, dtype=np.int64))


def beside(*meshes: Mesh) -> Mesh:
    shift = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return Mesh(
        vertices=np.concatenate([mesh.vertices for mesh in meshes]),
        faces=np.concatenate([m.faces + by for m, by in zip(meshes, shift, strict=True)]),
    )


CUBE = box(20.0, 20.0, 20.0)


def test_a_solid_is_left_as_it_is() -> None:
    found = repaired(CUBE, where="cube")
    assert found.mesh is CUBE
    assert found.steps == ()
    assert (found.volume_change, found.distance_mm) == (0.0, 0.0)


def test_triangles_without_common_corners_become_a_solid() -> None:
    soup = Mesh(vertices=CUBE.corners.reshape(-1, 3), faces=np.arange(36).reshape(-1, 3))
    found = repaired(soup, where="cube")
    assert found.steps == ("merged coinciding corners",)
    assert len(found.mesh.vertices) == 8
    assert found.volume_change == pytest.approx(0.0, abs=1e-12)


def test_a_mesh_inside_out_is_turned_and_told() -> None:
    found = repaired(Mesh(vertices=CUBE.vertices, faces=CUBE.faces[:, ::-1]), where="cube")
    assert found.steps == ("turned inside out",)
    assert found.mesh.volume == pytest.approx(8000.0)
    assert found.volume_change == pytest.approx(0.0, abs=1e-12)


def test_flipped_faces_are_wound_alike() -> None:
    faces = CUBE.faces.copy()
    faces[[1, 5]] = faces[[1, 5], ::-1]
    found = repaired(Mesh(vertices=CUBE.vertices, faces=faces), where="cube")
    assert found.steps == ("wound faces alike",)
    assert found.mesh.volume == pytest.approx(8000.0)


def test_a_crack_of_ten_micrometres_is_closed_by_manifold3d() -> None:
    # Four of the twelve triangles of the cube have corners of their own, 0.01 mm higher.
    faces = CUBE.faces.copy()
    faces[:4] += 8
    cracked = Mesh(
        vertices=np.concatenate([CUBE.vertices, CUBE.vertices + np.array([0, 0, 0.01])]),
        faces=faces,
    )
    found = repaired(cracked, where="cube")
    assert "closed cracks" in found.steps
    assert found.mesh.volume == pytest.approx(8000.0, rel=0.002)
    assert 0.0 < found.distance_mm <= 0.01 + 1e-9


def test_a_sliver_that_is_missing_is_filled() -> None:
    # The hole is 0.1 mm wide: no point of its lid is further than 0.05 mm from its rim.
    corners = [[0, 0], [20, 0], [20, 20], [0, 20], [10, 9.95], [10, 10.05]]
    lower = np.array([[x, y, 0.0] for x, y in corners])
    upper = lower + np.array([0.0, 0.0, 5.0])
    top = [(0, 1, 4), (1, 5, 4), (1, 2, 5), (2, 3, 5), (3, 0, 5), (0, 4, 5)]
    sides = [(a, b) for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))]
    faces = [(a + 6, b + 6, c + 6) for a, b, c in top] + [(c, b, a) for a, b, c in top]
    faces += [face for a, b in sides for face in ((a, b, b + 6), (a, b + 6, a + 6))]
    whole = Mesh(vertices=np.concatenate([lower, upper]), faces=np.array(faces))
    assert whole.volume == pytest.approx(2000.0)
    without = Mesh(vertices=whole.vertices, faces=np.delete(whole.faces, 1, axis=0))
    found = repaired(without, where="plate")
    assert "filled flat holes" in found.steps
    assert 0.0 < found.distance_mm <= 0.05


def test_a_hole_whose_lid_is_far_from_all_that_was_given_refuses_the_mesh() -> None:
    opened = Mesh(vertices=CUBE.vertices, faces=CUBE.faces[1:])
    with pytest.raises(SolidError, match=r"3 edges open.*move its surface by 5\.\d mm") as caught:
        repaired(opened, where="lidless")
    assert caught.value.where == "lidless"
    assert f"{DISTANCE_MM} mm is allowed" in caught.value.what


def test_shells_that_touch_are_joined_and_the_solid_is_the_same() -> None:
    found = repaired(beside(CUBE, box(20.0, 20.0, 20.0, at=(20.0, 0.0, 0.0))), where="two")
    assert found.steps == ("joined its shells, which share 0 % of their volume",)
    assert found.mesh.volume == pytest.approx(16000.0)
    assert len(found.mesh.manifold.decompose()) == 1


def test_shells_that_overlap_by_a_hundredth_are_joined_and_by_a_tenth_are_not() -> None:
    # 0.1 mm of 20: 0.1 * 400 / 15960 = 0.25 % is counted twice; 2 mm: 5 %.
    little = repaired(beside(CUBE, box(20.0, 20.0, 20.0, at=(19.9, 0.0, 0.0))), where="two")
    assert little.mesh.volume == pytest.approx(39.9 * 400.0)
    assert little.volume_change == pytest.approx(0.1 * 400 / 15960)
    much = repaired(beside(CUBE, box(20.0, 20.0, 20.0, at=(18.0, 0.0, 0.0))), where="two")
    assert much.steps == ()
    assert len(much.mesh.manifold.decompose()) == 2


def test_a_void_survives() -> None:
    inner = box(10.0, 10.0, 10.0)
    hollow = beside(CUBE, Mesh(vertices=inner.vertices, faces=inner.faces[:, ::-1]))
    assert repaired(hollow, where="hollow").mesh.volume == pytest.approx(7000.0)


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (Mesh(vertices=np.zeros((0, 3)), faces=np.zeros((0, 3), dtype=np.int64)), "empty"),
        (Mesh(vertices=np.full((3, 3), np.nan), faces=np.array([[0, 1, 2]])), "3 of its 3 corners"),
        (Mesh(vertices=np.zeros((3, 3)), faces=np.array([[0, 1, 7]])), "corner 7, and there are 3"),
        (Mesh(vertices=np.eye(3), faces=np.array([[0, 1, 2]])), "3 edges open"),
        (Mesh(vertices=np.eye(3), faces=np.array([[0, 1, 1]])), "nothing is left of it"),
        (Mesh(vertices=np.eye(3), faces=np.array([[0, 1, 2], [2, 1, 0]])), "encloses no|nothing"),
    ],
)
def test_what_encloses_nothing_is_refused_with_its_reason(mesh: Mesh, said: str) -> None:
    with pytest.raises(SolidError, match=said):
        repaired(mesh, where="part")
