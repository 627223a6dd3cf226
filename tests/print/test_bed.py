from __future__ import annotations

import numpy as np
import pytest
import trimesh

from morph.print.arrays import Array
from morph.print.bed import about_up, room
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("ender3"), material=material("pla"))
"""Its bed is 220 x 220 mm, of which 210 x 210 are used, and 250 high."""


def box(*size: float) -> Array:
    return np.asarray(trimesh.creation.box(extents=size).vertices)


def test_a_margin_of_five_millimetres_stays_free() -> None:
    assert room(PROFILE).tolist() == [210.0, 210.0, 250.0]


@pytest.mark.parametrize(
    ("size", "fits"),
    [
        ((210.0, 210.0, 250.0), True),
        ((210.1, 210.0, 10.0), False),
        ((10.0, 10.0, 250.1), False),
        # Across the diagonal a bar of width w and length l needs (l + w) / sqrt(2) <= 210.
        ((280.0, 16.0, 10.0), True),
        ((280.0, 18.0, 10.0), False),
    ],
)
def test_what_fits_is_what_geometry_says(size: tuple[float, ...], fits: bool) -> None:
    turn = about_up(box(*size), PROFILE)
    assert (turn is not None) == fits
    if turn is not None:
        turned = box(*size) @ turn.T
        assert (np.ptp(turned, axis=0) <= room(PROFILE) + 1e-9).all()


def test_a_turned_box_is_turned_back_to_its_least_area() -> None:
    angle = np.deg2rad(17.3)
    c, s = np.cos(angle), np.sin(angle)
    points = box(100.0, 40.0, 5.0) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
    turn = about_up(points, PROFILE)
    assert turn is not None
    np.testing.assert_allclose(np.sort(np.ptp(points @ turn.T, axis=0)), [5.0, 40.0, 100.0], 1e-4)
