from __future__ import annotations

import numpy as np
import pytest
import trimesh

from morph.print import facets
from morph.print.edges import edges
from morph.print.mesh import Mesh


def mesh_of(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices=np.array(shape.vertices), faces=np.array(shape.faces, dtype=np.int64))


@pytest.fixture
def ball() -> Mesh:
    return mesh_of(trimesh.creation.icosphere(subdivisions=2, radius=10.0))


def test_a_soup_of_triangles_gets_its_corners_back(ball: Mesh) -> None:
    soup = Mesh(
        vertices=ball.corners.reshape(-1, 3).astype(np.float32).astype(np.float64),
        faces=np.arange(3 * len(ball.faces)).reshape(-1, 3),
    )
    found = facets.merged(soup)
    assert len(found.vertices) == len(ball.vertices)
    assert edges(found).closed


def test_corners_a_micrometre_apart_stay_two_on_a_small_part(ball: Mesh) -> None:
    # 2^-21 of 10 mm is 5 nm.
    apart = np.concatenate([ball.vertices, ball.vertices[:1] + np.array([1e-3, 0, 0])])
    faces = np.where(ball.faces == 0, len(ball.vertices), ball.faces)
    both = Mesh(vertices=apart, faces=np.concatenate([ball.faces, faces]))
    assert len(facets.merged(both).vertices) == len(apart)


def test_doubles_go_and_the_order_of_the_rest_stays(ball: Mesh) -> None:
    faces = np.concatenate([ball.faces, ball.faces[5:8], ball.faces[9:10, [1, 2, 0]], [[4, 4, 7]]])
    found = facets.without_doubles(Mesh(vertices=ball.vertices, faces=faces))
    assert np.array_equal(found.faces, ball.faces)


def test_faces_back_to_back_enclose_nothing_and_both_go(ball: Mesh) -> None:
    # A sheet on three corners that no face of the ball joins.
    sheet = np.array([[0, 20, 40], [40, 20, 0]])
    faces = np.concatenate([ball.faces, sheet])
    found = facets.without_doubles(Mesh(vertices=ball.vertices, faces=faces))
    assert np.array_equal(found.faces, ball.faces)


def test_faces_are_wound_as_most_of_their_patch_is(ball: Mesh) -> None:
    faces = ball.faces.copy()
    # The first face among them, from which a search for neighbours begins.
    faces[:100] = faces[:100, ::-1]
    found = facets.wound_alike(Mesh(vertices=ball.vertices, faces=faces))
    assert found.volume == pytest.approx(ball.volume, rel=1e-12)


def test_the_shell_of_a_void_stays_inside_out(ball: Mesh) -> None:
    void = Mesh(vertices=ball.vertices * 0.5, faces=ball.faces[:, ::-1])
    faces = np.concatenate([ball.faces, void.faces + len(ball.vertices)])
    faces[3] = faces[3][::-1]
    both = Mesh(vertices=np.concatenate([ball.vertices, void.vertices]), faces=faces)
    # An eighth is missing inside: V (1 - 0.5^3).
    assert facets.wound_alike(both).volume == pytest.approx(ball.volume * 0.875, rel=1e-12)


def test_a_flat_hole_is_filled_and_a_bent_one_is_not() -> None:
    box = mesh_of(trimesh.creation.box((20.0, 30.0, 40.0)))
    up = trimesh.creation.box((20.0, 30.0, 40.0)).face_normals[:, 2] > 0.5
    lidless = Mesh(vertices=box.vertices, faces=box.faces[~up])
    found = facets.filled(lidless)
    assert found.volume == pytest.approx(24000.0)
    # Without two sides that meet the rim is a bent loop.
    beside = trimesh.creation.box((20.0, 30.0, 40.0)).face_normals[:, 0] > 0.5
    bent = Mesh(vertices=box.vertices, faces=box.faces[~(up | beside)])
    assert facets.filled(bent) is bent


def test_two_holes_have_two_rims(ball: Mesh) -> None:
    faces = np.delete(ball.faces, [0, 200], axis=0)
    rims = facets.rims(Mesh(vertices=ball.vertices, faces=faces))
    assert sorted(len(rim) for rim in rims) == [3, 3]
