"""What a browser draws is light, and looks like what was described."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.coarse import CLOSE, coarse
from morph.app.viewer.crease import creased
from morph.app.viewer.placeholders import edges
from morph.app.viewer.web_shapes import MOST_FACES, MOST_IN_ALL, shares, web_shapes
from morph.arrays import Array, Integers
from morph.body.mesh.solid import Mesh


def shape(solid: Any, **more: Any) -> PictureShape:
    given = {"body": 1, "colour": (9, 9, 9), "opacity": 1.0, "flat": True, **more}
    return PictureShape(
        vertices=np.array(solid.vertices, dtype=float),
        faces=np.array(solid.faces, dtype=np.int64),
        **given,
    )


def area(vertices: Array, faces: Integers) -> float:
    corner = vertices[faces]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return float(0.5 * np.linalg.norm(normal, axis=1).sum())


def test_a_box_gets_corners_of_its_own_for_every_side() -> None:
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    vertices, faces = creased(np.array(box.vertices), np.array(box.faces))
    # 6 sides of 4 corners each, for its edges are of 90 degrees.
    assert (len(vertices), len(faces)) == (24, 12)
    assert area(vertices, faces) == pytest.approx(22.0)


def test_a_ball_stays_whole() -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    vertices, faces = creased(np.array(ball.vertices), np.array(ball.faces))
    # Euler: 1280 faces have 642 corners; none is split, as faces meet at less than 10 degrees.
    assert (len(vertices), len(faces)) == (642, 1280)


def test_a_cylinder_is_split_along_its_two_rims_alone() -> None:
    solid = trimesh.creation.cylinder(radius=1.0, height=2.0, sections=32)
    vertices, _ = creased(np.array(solid.vertices), np.array(solid.faces))
    # Two rims of 32 corners twice, and the middles of the two lids.
    assert len(vertices) == 4 * 32 + 2


def test_corners_that_a_file_repeats_for_every_face_are_joined() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2)
    soup = np.array(ball.triangles).reshape(-1, 3)
    vertices, _ = creased(soup, np.arange(len(soup)).reshape(-1, 3))
    assert len(vertices) == len(ball.vertices)


def test_a_fine_ball_keeps_its_surface_with_a_tenth_of_the_faces() -> None:
    ball = trimesh.creation.icosphere(subdivisions=5)
    mesh = Mesh(vertices=np.array(ball.vertices), faces=np.array(ball.faces))
    light = coarse(mesh, 2048)
    assert len(light.faces) <= CLOSE * 2048
    # 2000 faces of a unit ball have edges of about 0.12, which sag by 0.12^2 / 8 = 0.002.
    radius = np.linalg.norm(light.vertices, axis=1)
    assert np.abs(radius - 1.0).max() < 0.01
    assert cKDTree(light.vertices).query(ball.vertices)[0].max() < 0.15


def test_loose_faces_are_thinned_all_the_same() -> None:
    rng = np.random.default_rng(5)
    soup = rng.uniform(size=(9000, 1, 3)) + 0.01 * rng.uniform(size=(9000, 3, 3))
    mesh = Mesh(vertices=soup.reshape(-1, 3), faces=np.arange(27000).reshape(-1, 3))
    assert 0 < len(coarse(mesh, 1000).faces) <= CLOSE * 1000


def test_shares_add_up_to_what_a_body_may_have() -> None:
    small, large = (trimesh.creation.icosphere(5, radius=radius) for radius in (0.1, 1.0))
    given = [shape(small)] * 15 + [shape(large)] * 15
    found = np.array(shares(given))
    assert found.sum() <= MOST_IN_ALL
    # The large ones have a hundred times the surface, so that they reach the limit of a shape.
    assert (found[15:] == MOST_FACES).all()
    assert (found[:15] < MOST_FACES).all()
    assert (found[:15] > 0.3 * MOST_FACES).all()


def test_what_is_light_keeps_every_face() -> None:
    ball = shape(trimesh.creation.icosphere(2))
    assert shares([ball, ball]) == [320, 320]


def test_shapes_of_one_link_colour_and_opacity_become_one() -> None:
    box = trimesh.creation.box()
    found = web_shapes(
        [shape(box), shape(box), shape(box, colour=(1, 1, 1)), shape(box, opacity=0.5)]
    )
    assert [len(each.faces) for each in found] == [24, 12, 12]
    assert found[0].faces.max() == len(found[0].vertices) - 1


@pytest.mark.parametrize(
    "bad",
    [
        {"vertices": np.full((8, 3), np.nan)},
        {"vertices": np.zeros((8, 3))},
        {"faces": np.zeros((0, 3), dtype=np.int64)},
        {"opacity": 0.0},
    ],
    ids=["not numbers", "a point", "no faces", "invisible"],
)
def test_what_cannot_be_seen_is_left_out(bad: dict[str, Any]) -> None:
    box = trimesh.creation.box()
    given = {"vertices": np.array(box.vertices), "faces": np.array(box.faces), "opacity": 1.0}
    one = PictureShape(body=1, colour=(1, 1, 1), flat=True, **{**given, **bad})
    assert web_shapes([one]) == ()


def test_a_box_of_mass_and_inertia_has_the_edges_it_was_made_of() -> None:
    # m = 2, edges 1, 2, 3: I_x = 2 (4 + 9) / 12, I_y = 2 (1 + 9) / 12, I_z = 2 (1 + 4) / 12.
    inertia = 2.0 / 12.0 * np.array([13.0, 10.0, 5.0])
    assert np.allclose(edges(2.0, inertia), (1.0, 2.0, 3.0))


def test_an_inertia_that_no_box_has_is_drawn_as_thin_as_can_be_seen() -> None:
    assert (edges(1.0, np.array([1.0, 0.1, 0.1])) >= 1e-3).all()
