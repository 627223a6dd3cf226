from __future__ import annotations

import manifold3d
import numpy as np
import pytest
import trimesh

from morph.print.errors import PlateError
from morph.print.mesh import Mesh, from_manifold
from morph.print.orient import fits, orient
from morph.print.overhang import standing
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))


def table() -> Mesh:
    """Return a plate of 40 x 40 on a leg of 10 x 10 x 20, as it stands in a room."""
    top = manifold3d.Manifold.cube((40, 40, 5)).translate((-20, -20, 20))
    return from_manifold(top + manifold3d.Manifold.cube((10, 10, 20)).translate((-5, -5, 0)))


def drawn(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices=np.asarray(shape.vertices), faces=np.asarray(shape.faces))


def test_a_table_is_printed_on_its_top() -> None:
    found = orient(table(), PROFILE)
    np.testing.assert_allclose(found.turn[2], [0, 0, -1], atol=1e-6)
    # As given, (1600 - 100) * 20 = 30000 mm3, to the half column of test_overhang.
    assert found.first_support_mm3 == pytest.approx(30000.0, rel=0.05)
    assert found.support_mm3 == 0.0
    assert found.height_mm == pytest.approx(25.0)


@pytest.mark.parametrize("seed", range(4))
def test_however_it_was_drawn_the_table_is_printed_on_its_top(seed: int) -> None:
    turn = trimesh.transformations.random_rotation_matrix(np.random.default_rng(seed).random(3))
    turn[:3, 3] = [100.0, -20.0, 3.0]
    found = orient(table().moved(turn), PROFILE)
    assert found.turn[2] @ turn[:3, 2] == pytest.approx(-1.0, abs=1e-3)
    assert found.support_mm3 < 1.0


def test_the_turn_is_a_rotation_and_the_numbers_are_those_of_what_it_turns() -> None:
    mesh = drawn(trimesh.creation.annulus(r_min=10.0, r_max=30.0, height=60.0))
    found = orient(mesh, PROFILE)
    np.testing.assert_allclose(found.turn @ found.turn.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(found.turn) == pytest.approx(1.0)
    again = standing(mesh.corners @ found.turn.T, PROFILE)
    # Turned about upright by other columns; a ring on its end has no support at all.
    assert found.support_mm3 == again.support_mm3 == 0.0
    assert found.height_mm == pytest.approx(60.0)


def test_a_needle_lies_rather_than_stands() -> None:
    # Upright a rod of radius 1 and length 80 would need no support, and would fall.
    found = orient(drawn(trimesh.creation.cylinder(radius=1.0, height=80.0)), PROFILE)
    assert found.height_mm < 3.0


def test_a_long_part_lies_across_the_diagonal() -> None:
    # (290 + 10) / sqrt(2) = 212 > 200, and 240 x 200 has a diagonal of 312.
    mesh = drawn(trimesh.creation.box(extents=(290.0, 10.0, 10.0)))
    assert fits(mesh, PROFILE)
    size = np.ptp(mesh.vertices @ orient(mesh, PROFILE).turn.T, axis=0)
    assert (size <= [240.0, 200.0, 220.0]).all()
    assert size[2] == pytest.approx(10.0)


def test_what_is_too_large_is_said_with_its_size() -> None:
    mesh = drawn(trimesh.creation.box(extents=(400.0, 30.0, 20.0)))
    assert not fits(mesh, PROFILE)
    with pytest.raises(PlateError, match="a part of 400 x 30 x 20 mm fits the 240 x 200 x 220 mm"):
        orient(mesh, PROFILE)
