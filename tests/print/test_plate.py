from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.print.arrays import Array
from morph.print.errors import PlateError
from morph.print.job import Orientation, Plate
from morph.print.mesh import Mesh
from morph.print.part import Part, Placement
from morph.print.plate import plates
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))
"""Its bed is 250 x 210 mm, of which 240 x 200 are used."""


def block(name: str, size: tuple[float, float, float], count: int = 1) -> Part:
    box = trimesh.creation.box(extents=size)
    here = Placement(link="body", pose=np.eye(4), world=np.eye(4))
    # Not about its middle: a part's frame may be anywhere.
    away = np.array([7.0, -300.0, 41.0])
    mesh = Mesh(vertices=np.asarray(box.vertices) + away, faces=np.array(box.faces))
    return Part(name=name, kind="printed", mesh=mesh, placements=(here,) * count)


def lying(turn: Array | None = None) -> Orientation:
    turn = np.eye(3) if turn is None else turn
    return Orientation(turn=turn, support_mm3=0.0, first_support_mm3=0.0, height_mm=1.0)


def boxes(plate: Plate, parts: list[Part]) -> Array:
    by_name = {part.name: part for part in parts}
    found = []
    for laid in plate.laid:
        mesh = by_name[laid.part].mesh
        assert mesh is not None
        found.append(mesh.moved(laid.pose).bounds)
    return np.array(found)


@given(
    sizes=st.lists(
        st.tuples(
            st.floats(1.0, 150.0), st.floats(1.0, 150.0), st.floats(1.0, 150.0), st.integers(1, 3)
        ),
        min_size=1,
        max_size=12,
    )
)
@settings(max_examples=60, deadline=None)
def test_every_copy_is_there_once_inside_the_bed_and_clear_of_others(
    sizes: list[tuple[float, float, float, int]],
) -> None:
    parts = [block(f"part_{at}", size[:3], size[3]) for at, size in enumerate(sizes)]
    found = plates(parts, {part.name: lying() for part in parts}, PROFILE)
    copies = Counter((laid.part, laid.copy) for plate in found for laid in plate.laid)
    assert copies == Counter((part.name, copy) for part in parts for copy in range(part.count))
    for plate in found:
        low, high = boxes(plate, parts).transpose(1, 0, 2)
        assert (low[:, :2] >= 5.0 - 1e-6).all()
        assert (high <= np.array([245.0, 205.0, 220.0]) + 1e-6).all()
        np.testing.assert_allclose(low[:, 2], 0.0, atol=1e-9)
        gap = np.maximum(low[:, None] - high, low - high[:, None])[..., :2].max(axis=2)
        np.fill_diagonal(gap, np.inf)
        assert (gap >= 6.0 - 1e-6).all()


def test_as_many_squares_lie_on_a_plate_as_a_grid_holds() -> None:
    # (240 + 6) / (40 + 6) = 5.3 and (200 + 6) / 46 = 4.5: 5 * 4 = 20 on a plate, 41 on three.
    part = block("tile", (40.0, 40.0, 5.0), 41)
    found = plates([part], {"tile": lying()}, PROFILE)
    assert [len(plate.laid) for plate in found] == [20, 20, 1]


def test_a_part_is_turned_where_only_that_brings_it_in() -> None:
    # 230 mm is more than the depth of 200 and less than the width of 240.
    part = block("sheet", (195.0, 230.0, 5.0))
    (plate,) = plates([part], {"sheet": lying()}, PROFILE)
    np.testing.assert_allclose(np.ptp(boxes(plate, [part])[0], axis=0), [230.0, 195.0, 5.0])


def test_orientations_are_kept_up_to_a_turn_about_upright() -> None:
    part = block("bar", (10.0, 20.0, 100.0))
    down = trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0])[:3, :3]
    (plate,) = plates([part], {"bar": lying(down)}, PROFILE)
    np.testing.assert_allclose(plate.laid[0].pose[2, :3], down[2], atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(plate.laid[0].pose), 1.0)
    assert part.mesh is not None
    np.testing.assert_allclose(part.mesh.moved(plate.laid[0].pose).extent[2], 10.0)


def test_what_is_larger_than_the_bed_or_lies_nowhere_is_named() -> None:
    part = block("bar", (300.0, 20.0, 20.0))
    with pytest.raises(PlateError, match=r"part bar: the part is 300\.0 x 20\.0 x 20\.0 mm"):
        plates([part], {"bar": lying()}, PROFILE)
    with pytest.raises(PlateError, match="part bar: nobody said how the part lies"):
        plates([part], {}, PROFILE)


def test_nothing_needs_no_plate() -> None:
    assert plates([], {}, PROFILE) == ()
