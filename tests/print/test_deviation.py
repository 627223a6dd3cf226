from __future__ import annotations

import numpy as np
import pytest
import trimesh

from morph.print.deviation import deviation
from morph.print.mesh import Mesh


def cube(side: float = 20.0) -> Mesh:
    box = trimesh.creation.box((side, side, side))
    return Mesh(vertices=np.array(box.vertices), faces=np.array(box.faces, dtype=np.int64))


def test_a_mesh_is_nowhere_from_itself_in_another_order() -> None:
    whole = cube()
    turned = Mesh(vertices=whole.vertices, faces=np.roll(whole.faces[::-1], 1, axis=1))
    found = deviation(whole, turned)
    assert found.volume == pytest.approx(0.0, abs=1e-12)
    assert found.distance_mm == 0.0


def test_a_larger_cube_is_further_by_half_of_its_growth() -> None:
    # 20 to 20.4 mm: each side moves 0.2 mm, corners sqrt(3) times as far; the volume by 1.02^3.
    found = deviation(cube(), cube(20.4))
    assert 0.2 <= found.distance_mm <= 0.2 * np.sqrt(3.0) + 1e-9
    assert found.volume == pytest.approx(1.02**3 - 1.0)


def test_the_volume_of_an_open_mesh_is_not_compared() -> None:
    whole = cube()
    opened = Mesh(vertices=whole.vertices, faces=whole.faces[1:])
    assert deviation(opened, whole).volume is None


def test_the_middle_of_a_lid_is_as_far_as_the_rim_of_its_hole() -> None:
    # Half a side of 20 mm is missing: a right triangle of legs 20 and 20, whose incentre is
    # 20 (1 - 1 / sqrt 2) = 5.86 mm from each edge. Of 400 points in 200 mm2, 0.7 mm apart, the
    # nearest to it is at most about as far from it.
    whole = cube()
    opened = Mesh(vertices=whole.vertices, faces=whole.faces[1:])
    assert deviation(opened, whole).distance_mm == pytest.approx(5.86, abs=0.7)
