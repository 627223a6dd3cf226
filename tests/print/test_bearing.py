from __future__ import annotations

import math

import pytest

from morph.print.bearing import BEARINGS, bearing, seat
from morph.print.errors import SeatError
from morph.print.screw import SCREWS, screw


def test_bearings_have_the_sizes_of_iso_15() -> None:
    # Bore, outer diameter and width as every maker's catalogue has them.
    sizes = {each.name: (each.bore_mm, each.outer_mm, each.width_mm) for each in BEARINGS}
    assert sizes["608"] == (8.0, 22.0, 7.0)
    assert sizes["623"] == (3.0, 10.0, 4.0)
    assert sizes["MR105"] == (5.0, 10.0, 4.0)


@pytest.mark.parametrize("which", BEARINGS, ids=lambda each: each.name)
def test_a_seat_is_a_cylinder_with_play(which) -> None:  # type: ignore[no-untyped-def]
    room = seat(which, 0.1)
    closed = math.pi * (which.outer_mm / 2 + 0.1) ** 2 * which.width_mm
    # Faces of 0.02 mm sagitta at most: 2 * 0.02 / 5 = 0.8 % of the area; its mouth adds 0.01 mm.
    assert room.volume == pytest.approx(closed, rel=0.01)
    assert room.bounds[0, 2] == pytest.approx(-which.width_mm)
    assert which.bore_mm == screw(which.screw).thread_mm


def test_holes_let_screws_through_or_hold_them() -> None:
    for each in SCREWS:
        assert each.tap_mm <= each.thread_mm < each.clear_mm < each.head_mm


def test_what_is_unknown_is_named() -> None:
    with pytest.raises(SeatError, match="609"):
        bearing("609")
    with pytest.raises(SeatError, match="M7"):
        screw("M7")
