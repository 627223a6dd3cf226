from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from morph.print.callout import LINE, callouts, spread
from morph.print.decimate import lighter
from morph.print.mesh import Mesh
from morph.print.picture import PlacedMesh, picture

FRONT = np.array([0.0, -1.0, 1e-9])


def box(x: float, y: float, z: float = 0.0) -> Mesh:
    solid = trimesh.creation.box((10.0, 10.0, 10.0))
    shifted = np.array(solid.vertices) + np.array((x, y, z))
    return Mesh(vertices=shifted, faces=np.array(solid.faces, dtype=np.int64))


def fills(svg: str) -> list[str]:
    """Colours of faces in the order in which they are painted, without edges and numbers."""
    root = ElementTree.fromstring(svg)
    faces = root[1]
    return [str(each.get("fill")) for each in faces if each.get("fill") != "none"]


def test_what_is_nearer_is_painted_later_whatever_was_named_first() -> None:
    red, blue = (
        PlacedMesh(mesh=box(0, 20), colour=(255, 0, 0)),
        PlacedMesh(mesh=box(0, 0), colour=(0, 0, 255)),
    )
    for drawn in ([red, blue], [blue, red]):
        painted = fills(picture(drawn, title="two", towards=FRONT))
        assert [colour[1:3] != "00" for colour in painted] == [True, False]


def test_faces_that_look_away_are_not_there() -> None:
    svg = picture([PlacedMesh(mesh=box(0, 0), colour=(9, 9, 9))], title="one", towards=FRONT)
    # A box seen from its front shows one side: two triangles.
    assert sum(path.count("z") for path in re.findall(r' d="([^"]*)"', svg)) == 2


def test_only_edges_of_a_box_are_drawn_and_not_the_diagonals_of_its_sides() -> None:
    svg = picture([PlacedMesh(mesh=box(0, 0), colour=(9, 9, 9))], title="one", towards=FRONT)
    (lines,) = re.findall(r'stroke="#24303c" fill="none" d="([^"]*)"', svg)
    assert lines.count("M") == 4


def test_everything_stays_within_the_drawing_and_names_do_no_harm() -> None:
    drawn = [
        PlacedMesh(mesh=box(30.0 * at, 7.0 * at, -9.0 * at), colour=(200, 90, 9), label=f"<P-{at}>")
        for at in range(12)
    ]
    svg = picture(drawn, title='<script>"&')
    root = ElementTree.fromstring(svg)
    _, _, wide, tall = map(float, str(root.get("viewBox")).split())
    numbers = re.findall(r"M(-?[\d.]+)[ ]?(-?[\d.]+)", svg)
    for x, y in numbers:
        assert 0.0 <= float(x) <= wide
        assert 0.0 <= float(y) <= tall
    assert "&lt;P-3&gt;" in svg
    assert "<script>" not in svg


def test_a_drawing_of_a_fine_mesh_is_light() -> None:
    ball = trimesh.creation.icosphere(subdivisions=6)
    mesh = Mesh(vertices=np.array(ball.vertices), faces=np.array(ball.faces, dtype=np.int64))
    assert len(mesh.faces) > 80_000
    assert len(picture([PlacedMesh(mesh=mesh, colour=(1, 2, 3))] * 4, title="balls")) < 300_000


def test_a_plate_that_is_full_of_holes_is_light_too() -> None:
    holes = [
        trimesh.creation.cylinder(1.0, 9.0, sections=64).apply_translation((3.0 * x, 3.0 * y, 0.0))
        for x in range(8)
        for y in range(4)
    ]
    plate = trimesh.creation.box((30.0, 20.0, 5.0)).apply_translation((10.5, 4.5, 0.0))
    drilled = trimesh.boolean.difference([plate, *holes], engine="manifold")
    mesh = Mesh(vertices=np.array(drilled.vertices), faces=np.array(drilled.faces, dtype=np.int64))
    assert len(mesh.faces) > 4000
    few = lighter(mesh, 300)
    assert 100 < len(few.faces) <= 1300
    np.testing.assert_allclose(few.extent, mesh.extent, atol=0.8)


@pytest.mark.parametrize("wanted", [[50.0] * 5, [0.0, 1.0, 290.0, 300.0], [10.0, 200.0]])
def test_numbers_do_not_lie_on_each_other(wanted: list[float]) -> None:
    heights = spread(np.array(wanted), 300.0)
    assert (np.diff(heights) >= LINE - 1e-9).all()
    assert heights.min() >= 0.0
    assert heights.max() <= 300.0


def test_numbers_that_have_room_stay_where_they_are_wanted() -> None:
    np.testing.assert_allclose(spread(np.array([50.0, 100.0, 200.0]), 300.0), [50, 100, 200])


def test_numbers_stand_on_the_side_of_what_they_name_in_its_order() -> None:
    told = callouts(
        [
            ("a", np.array([10.0, 90.0])),
            ("b", np.array([20.0, 30.0])),
            ("c", np.array([90.0, 5.0])),
        ],
        width=100.0,
        height=100.0,
    )
    assert [each.text for each in told] == ["b", "a", "c"]
    assert told[0].at[0] < told[2].at[0]
