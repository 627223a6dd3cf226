from __future__ import annotations

import manifold3d
import numpy as np
import pytest
import trimesh

from morph.print.errors import SolidError
from morph.print.mesh import Mesh
from morph.print.sections import all_of, inset, moments, sections, shared


def of(solid: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices=np.array(solid.vertices), faces=np.array(solid.faces))


def square(size: float, at: tuple[float, float] = (0.0, 0.0)) -> manifold3d.CrossSection:
    return manifold3d.CrossSection.square((size, size)).translate(at)


def test_a_rectangle_has_the_moments_of_the_textbook() -> None:
    found = moments(manifold3d.CrossSection.square((4.0, 2.0)).translate((1.0, 5.0)))
    # About its middle (3, 6): area 8, a b3 / 12 each way; then Steiner. The product about the
    # middle of a rectangle is nothing.
    area, x, y = 8.0, 3.0, 6.0
    assert found == pytest.approx(
        [
            area,
            area * x,
            area * y,
            2.0 * 4.0**3 / 12 + area * x * x,
            area * x * y,
            4.0 * 2.0**3 / 12 + area * y * y,
        ]
    )


def test_a_hole_counts_against_its_plate() -> None:
    plate, hole = square(10.0), square(4.0, (5.0, 2.0))
    assert moments(plate - hole) == pytest.approx(moments(plate) - moments(hole))


def test_nothing_has_no_moments() -> None:
    assert not moments(all_of([])).any()


def test_a_solid_is_cut_at_the_middle_of_each_layer() -> None:
    # A cone of 10 mm, 10 wide at its foot: at height z its radius is 10 - z. Of 50 layers of
    # 0.2 mm the lowest is cut at 0.1 mm and the topmost at 9.9 mm. A cone of 64 sides has
    # (64 / 2 pi) sin(2 pi / 64) = 0.9984 of a circle;
    # corners that stand out less than 0.01 mm are left out.
    cuts = sections(of(trimesh.creation.cone(radius=10, height=10, sections=64)), 0.2)
    assert len(cuts) == 50
    for layer in (0, 25, 49):
        radius = 10 - (layer + 0.5) * 0.2
        assert cuts[layer].area() == pytest.approx(0.9984 * np.pi * radius**2, rel=1e-3, abs=0.01)


@pytest.mark.parametrize(("height", "count"), [(0.05, 1), (0.2, 1), (0.29, 1), (0.31, 2), (1.0, 5)])
def test_a_last_layer_is_there_if_more_than_half_of_it_is(height: float, count: int) -> None:
    slab = trimesh.creation.box(bounds=[[0, 0, 0], [5, 5, height]])
    assert len(sections(of(slab), 0.2)) == count


def test_what_is_open_is_not_cut() -> None:
    box = trimesh.creation.box((5, 5, 5))
    with pytest.raises(SolidError):
        sections(Mesh(vertices=np.array(box.vertices), faces=np.array(box.faces[:-1])), 0.2)


def test_insets_and_shared_areas_are_those_of_squares() -> None:
    assert inset(square(10.0), 1.5).area() == pytest.approx(49.0)
    assert inset(square(2.0), 1.5).area() == 0.0
    both = [square(4.0), square(4.0, (1.0, 0.0)), square(4.0, (2.0, 3.0))]
    assert shared(both).area() == pytest.approx(2.0 * 1.0)
    # 16 each, less what the first two share, 3 x 4, and the last with both, 3 x 1.
    assert all_of(both).area() == pytest.approx(16 + 4 + 16 - 3)
