from __future__ import annotations

import numpy as np
import pytest
import trimesh

from morph.print.mesh import Mesh
from morph.print.orientation_cost import COOL_S, DRAWN, plastic, seconds, ways
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))
DOWN = np.array([[0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])


def drawn(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices=np.asarray(shape.vertices), faces=np.asarray(shape.faces))


def test_outlines_are_as_long_as_layers_times_their_edge() -> None:
    box = ways(drawn(trimesh.creation.box(extents=(10.0, 20.0, 30.0))), DOWN, PROFILE)
    # On its end 150 layers of 60 mm; on its side 50 layers of 100 mm.
    assert box.outline == pytest.approx([9000.0, 5000.0])
    assert box.height == pytest.approx([30.0, 10.0])
    assert box.support == pytest.approx([0.0, 0.0])


def test_of_many_faces_some_stand_for_all() -> None:
    ball = drawn(trimesh.creation.icosphere(subdivisions=5, radius=20.0))
    assert len(ball.faces) == 20480 > DRAWN
    found = ways(ball, DOWN, PROFILE)
    # A sphere's sides seen: the integral of 2 pi r dz over 40 mm by r = sqrt(R2 - z2), which is
    # pi2 R2 = 3948 mm2, in layers of 0.2 mm.
    assert found.outline == pytest.approx(np.pi**2 * 400.0 / 0.2, rel=0.01)
    # Below 50 degrees: 2 pi R2 times the integral of s (R - R s) ds from sin 50 to 1, 0.16 of
    # it plastic, and 0.4 mm on the disc of radius R cos 50.
    s = np.sin(np.deg2rad(50.0))
    under = 2.0 * np.pi * 20.0**3 * ((1 - s**2) / 2 - (1 - s**3) / 3)
    disc = np.pi * (20.0 * np.cos(np.deg2rad(50.0))) ** 2
    assert found.support == pytest.approx(0.16 * under + 0.4 * disc, rel=0.03)


def test_a_part_takes_its_walls_and_a_share_of_its_inside() -> None:
    # Walls 2 * 0.45 mm on 6 * 400 mm2 are 2160 of 8000 mm3, and 15 % of the rest is 876.
    assert plastic(drawn(trimesh.creation.box(extents=(20, 20, 20))), PROFILE) == pytest.approx(
        2160.0 + 0.15 * 5840.0
    )
    # A sheet thinner than its walls is solid.
    sheet = drawn(trimesh.creation.box(extents=(50.0, 50.0, 1.0)))
    assert plastic(sheet, PROFILE) == pytest.approx(2500.0)


def test_small_layers_wait_until_they_are_hard() -> None:
    needle = drawn(trimesh.creation.box(extents=(2.0, 2.0, 40.0)))
    upright, lying = seconds(ways(needle, DOWN, PROFILE), plastic(needle, PROFILE), PROFILE)
    # 200 layers upright, 10 lying, each at least 15 s.
    assert upright == pytest.approx(200 * COOL_S)
    assert lying >= 10 * COOL_S
    assert lying < 0.1 * upright
