from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from morph.app.viewer.printed.skin import BED, HOT, PLAIN, WARM, Skin, overhang, thickness, wall
from morph.arrays import Array
from morph.print.job import Job, Orientation
from morph.print.mesh import Mesh
from morph.print.part import Part
from morph.print.printer import Profile, material, printer


def skin_of(mesh: Mesh) -> Skin:
    """A skin each of whose triangles has corners of its own: flat, as edges are drawn."""
    part = Part(name="part", kind="printed", mesh=mesh, placements=())
    corners = mesh.vertices[mesh.faces].reshape(-1, 3)
    return Skin(part=part, vertices=corners, faces=np.arange(len(corners)).reshape(-1, 3))


def box(*size: float) -> Mesh:
    solid = trimesh.creation.box(size)
    return Mesh(vertices=np.array(solid.vertices), faces=np.array(solid.faces, dtype=np.int64))


@pytest.fixture
def job() -> Callable[[Array], Job]:
    """Makes a job in which the part lies as it is told."""

    def made(turn: Array) -> Job:
        lies = Orientation(turn=turn, support_mm3=0.0, first_support_mm3=0.0, height_mm=1.0)
        return Job(
            profile=Profile(printer=printer("mk4"), material=material("pla")),
            parts=(),
            refused=(),
            checks=(),
            orientations={"part": lies},
            sliced={},
            plates=(),
        )

    return made


def tilted(degrees: float) -> Array:
    angle = np.radians(degrees)
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def faces_towards(skin: Skin, turn: Array, colours: Array) -> dict[tuple[int, ...], Array]:
    """The colour of each side of a box, by the rounded normal in its own frame."""
    return {
        tuple(np.rint(normal).astype(int).tolist()): colour
        for normal, colour in zip(skin.normals, colours, strict=True)
    }


def test_a_box_lies_on_the_bed_and_leans_nowhere(job: Callable[[Array], Job]) -> None:
    skin = skin_of(box(10, 10, 10))
    colours = overhang(skin, job(np.eye(3)))
    assert colours is not None
    sides = faces_towards(skin, np.eye(3), colours)
    np.testing.assert_array_equal(sides[0, 0, -1], BED)
    for side in ((1, 0, 0), (0, -1, 0), (0, 0, 1)):
        np.testing.assert_array_equal(sides[side], PLAIN)


# Tilted about x by t, the side that looked down leans out by 90 - t from upright, and the side
# that looked along -y by t; 50 degrees are allowed, and up to 15 count as upright.
@pytest.mark.parametrize(
    ("tilt", "below", "front"),
    [(30.0, HOT, 3 / 7 * WARM + 4 / 7 * PLAIN), (45.0, None, None), (10.0, HOT, PLAIN)],
)
def test_a_tilted_box_needs_support_where_it_leans_out_too_far(
    job: Callable[[Array], Job], tilt: float, below: Array | None, front: Array | None
) -> None:
    skin, turn = skin_of(box(10, 10, 10)), tilted(tilt)
    colours = overhang(skin, job(turn))
    assert colours is not None
    sides = faces_towards(skin, turn, colours)
    if below is None or front is None:
        # 45 of 50 degrees: both sides alike, (45 - 15) / (50 - 15) of the way to warm.
        np.testing.assert_allclose(sides[0, 0, -1], PLAIN + 30 / 35 * (WARM - PLAIN), atol=1e-6)
        np.testing.assert_allclose(sides[0, 0, -1], sides[0, -1, 0], atol=1e-6)
        return
    np.testing.assert_allclose(sides[0, 0, -1], below)
    np.testing.assert_allclose(sides[0, -1, 0], front, atol=1e-6)


def test_thickness_is_how_far_it_is_to_the_other_side() -> None:
    mesh = box(30.0, 20.0, 0.5)
    depth = thickness(mesh, skin_of(mesh))
    by_side = {round(each, 3) for each in depth.tolist()}
    assert by_side == {30.0, 20.0, 0.5}


@pytest.mark.parametrize(
    ("thick", "colour"),
    # Two lines of 0.45 mm are 0.9 mm; four times that is thick; 2.25 mm is half way between.
    [(0.89, HOT), (0.9, WARM), (2.25, 0.5 * (WARM + PLAIN)), (3.6, PLAIN), (9.0, PLAIN)],
)
def test_walls_are_coloured_by_lines_that_they_hold(
    job: Callable[[Array], Job], thick: float, colour: Array
) -> None:
    skin = skin_of(box(30.0, 20.0, thick))
    colours = wall(skin, job(np.eye(3)))
    assert colours is not None
    flat = np.abs(skin.normals[:, 2]) > 0.5
    # A ray starts 1 um within the surface and its hit is a share of its way: 1e-6 of 40 mm.
    np.testing.assert_allclose(
        colours[flat], np.broadcast_to(colour, colours[flat].shape), atol=0.02
    )


def test_what_is_bought_or_open_has_no_colours_of_its_own(job: Callable[[Array], Job]) -> None:
    whole = box(10, 10, 10)
    open_box = Mesh(vertices=whole.vertices, faces=whole.faces[2:])
    assert wall(skin_of(open_box), job(np.eye(3))) is None
    bought = Part(name="servo", kind="bought", mesh=whole, placements=())
    skin = Skin(part=bought, vertices=whole.vertices, faces=whole.faces)
    assert wall(skin, job(np.eye(3))) is None
    assert overhang(skin, job(np.eye(3))) is None
