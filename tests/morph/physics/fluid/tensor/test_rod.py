"""Cylinders and capsules, between discs, balls and endless rods, and against panels."""

from __future__ import annotations

import math

import numpy as np
import pytest

from morph.errors import RobotError
from morph.physics.fluid.tensor import rod_tensor, tensor_of_solid
from morph.physics.fluid.wetted.tessellate import capsule_mesh, cylinder_mesh


def test_a_thin_cylinder_is_lambs_disc() -> None:
    found = np.diag(rod_tensor(1.0, 0.002, rounded=False).matrix)
    # 8/3 a^3 and 16/45 a^5 (Lamb 1932, art. 102 and 115). Its edge adds as t ln(1 / t): for
    # t = 0.002 some 0.5 %, and a disc's slow order leaves some 1.5 %.
    assert found[2] == pytest.approx(8 / 3, rel=0.025)
    assert found[3] == pytest.approx(16 / 45, rel=0.03)


def test_a_capsule_without_a_side_is_a_ball() -> None:
    tensor = rod_tensor(1.0, 1e-3, rounded=True)
    # Half the volume of a ball that is 0.075 % larger; flatter across by as little.
    assert np.diag(tensor.matrix)[:3] == pytest.approx(0.5 * tensor.volume, rel=1e-3)
    assert np.abs(np.diag(tensor.matrix)[3:]).max() < 1e-5


def test_a_long_rod_drags_what_it_displaces_along_its_length() -> None:
    # Pi rho r^2 a length across it (Lamb 1932, art. 68), less at each end what water that flows
    # round it saves: of the order of a radius, of 100.
    tensor = rod_tensor(0.01, 1.0, rounded=False)
    across, along = tensor.matrix[0, 0] / tensor.volume, tensor.matrix[2, 2]
    assert 0.98 < across < 1.0
    # A rounded end of radius r moves some part of its own half ball, 2/3 pi r^3.
    assert along < 2.0 * math.pi * 0.01**3
    # A strip at s moves at w s: pi r^2 integral of s^2 ds = V L^2 / 12. What the ends lose
    # counts three times there, as they move three times the mean square.
    lost = 1.0 - across
    due = tensor.volume / 12.0 * (1.0 - 3.0 * lost)
    assert tensor.matrix[3, 3] == pytest.approx(due, rel=0.005)


@pytest.mark.parametrize("rounded", [True, False])
def test_a_rod_is_what_plain_triangles_say(rounded: bool) -> None:
    mesh = capsule_mesh(0.5, 1.0) if rounded else cylinder_mesh(0.5, 1.0)
    plain = tensor_of_solid(mesh.vertices, mesh.faces)
    found = rod_tensor(0.5, 1.0, rounded=rounded)
    assert found.error < 0.01
    # The triangles own up to their error, of the worst entry.
    assert np.diag(found.matrix)[:3] == pytest.approx(np.diag(plain.matrix)[:3], rel=plain.error)
    assert plain.error < 0.04


def test_twice_the_size_is_8_and_32_times_the_tensor() -> None:
    one, two = (np.diag(rod_tensor(s, 3.0 * s, rounded=True).matrix) for s in (0.1, 0.2))
    assert two[:3] == pytest.approx(8 * one[:3], rel=1e-12)
    assert two[3:5] == pytest.approx(32 * one[3:5], rel=1e-12)


@pytest.mark.parametrize(
    ("radius", "length", "said"),
    [
        (0.0, 1.0, "radius = 0 m"),
        (math.nan, 1.0, "radius = nan m"),
        (0.1, -1.0, "length = -1 m"),
        (1e-4, 1.0, "one is below 0.001 of the other"),
        (1.0, 1e-4, "one is below 0.001 of the other"),
    ],
)
def test_a_rod_that_is_none_or_too_thin_is_refused(radius: float, length: float, said: str) -> None:
    with pytest.raises(RobotError, match=said):
        rod_tensor(radius, length, rounded=False)
