from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from morph.print.section import section

circle, square = manifold3d.CrossSection.circle, manifold3d.CrossSection.square


def test_the_deepest_place_of_a_ring_is_in_the_middle_of_its_wall() -> None:
    ring = circle(20.0, 128) - circle(14.0, 128)
    found = section(ring)
    assert found is not None
    # Depths are told half a square and half a diagonal too small at most, 40 / 500 = 0.1 mm a side.
    assert found.deepest == pytest.approx(3.0, abs=0.15)
    assert found.deepest <= 3.0
    assert np.linalg.norm(found.outermost(2.8), axis=1) == pytest.approx(17.0, abs=0.3)
    assert found.at(np.zeros(2)) == 0.0
    assert found.at(np.array([17.0, 0.0])) > 2.8
    assert found.at(np.array([500.0, 0.0])) == 0.0


def test_material_is_as_much_as_the_shape_has() -> None:
    shape = square((31.0, 7.0)).translate((100.0, -50.0)) - square((5.0, 5.0)).translate((110, -49))
    found = section(shape)
    assert found is not None
    # 31 * 7 - 25 = 192 mm2; a row of squares more or less on 96 mm of edge is 96 * 0.1 / 2 = 5.
    assert found.inside.sum() * found.pitch**2 == pytest.approx(192.0, abs=5.0)


def test_the_outermost_places_hold_the_farthest_pair() -> None:
    found = section(square((60.0, 8.0)).rotate(33.0))
    assert found is not None
    points = found.outermost(3.0)
    apart = np.linalg.norm(points[:, None] - points, axis=2).max()
    # What lies 3 mm deep is a box of 54 x 2, whose diagonal is 54.04.
    assert apart == pytest.approx(54.04, abs=0.3)


def test_nothing_has_no_section() -> None:
    assert section(manifold3d.CrossSection()) is None
    assert section(manifold3d.Manifold.cube((1, 1, 1)).slice(5.0)) is None
