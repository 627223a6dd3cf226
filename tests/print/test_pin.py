from __future__ import annotations

import manifold3d
import numpy as np
import pytest

from morph.print.pin import Pin, pins
from morph.print.printer import Profile, material, printer

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))
PLAY = PROFILE.clearance_mm


def bar(x: float, y: float) -> tuple[manifold3d.Manifold, manifold3d.Manifold]:
    """Return the lower and the upper half of a bar that is cut at z = 0."""
    above = manifold3d.Manifold.cube((x, y, 50.0))
    return above.translate((0.0, 0.0, -50.0)), above


def test_a_stout_bar_gets_two_unlike_pins_at_its_far_ends() -> None:
    thick, thin = pins(*bar(40.0, 20.0), PROFILE)
    assert (thick.radius, thin.radius) == (5.0, 4.25)
    # Walls of 0.9 and play of 0.2 around: 40 - (5 + 4.25 + 2.2) = 28.6 at least along the bar.
    assert np.linalg.norm(thick.middle - thin.middle) > 28.0
    # The thick pin must not go into the thin one's hole.
    assert thick.radius > thin.radius + 2.0 * PLAY


def test_a_pin_goes_into_its_hole_with_its_play_and_into_no_other() -> None:
    thick, thin = pins(*bar(40.0, 20.0), PROFILE)
    hole = thick.hole(PLAY)
    above = thick.solid().trim_by_plane((0.0, 0.0, 1.0), 0.0)
    assert (above - hole).is_empty()
    wall = manifold3d.Manifold.cube((40, 40, 40), True).translate((*thick.middle, 0.0)) - hole
    shaft = above.trim_by_plane((0.0, 0.0, 1.0), 0.5)
    # Both are polygons of 48 sides; the sides of one are cos(pi / 48) = 0.998 of its radius away.
    assert shaft.min_gap(wall, 2.0) == pytest.approx(PLAY, abs=0.02)
    there = (*(thin.middle - thick.middle), 0.0)
    assert (above.translate(there) - thin.hole(PLAY)).volume() > 10.0


def test_pins_have_the_volume_of_what_they_are() -> None:
    pin = Pin(middle=np.zeros(2), radius=4.0, length=10.0)
    # A polygon of 48 sides has 48 / 2 sin(2 pi / 48) r2; the cone between R and r' of 0.6 mm
    # h / 3 (R2 + R r' + r'2) of the same shape, r' = 4 - 0.3.
    area = 24.0 * np.sin(2.0 * np.pi / 48.0)
    cone = 0.6 / 3.0 * (16.0 + 4.0 * 3.7 + 3.7**2)
    assert pin.solid().volume() == pytest.approx(area * (16.0 * (1.0 + 9.4) + cone), rel=1e-6)


def test_a_thin_rod_gets_a_single_pin_that_goes_in_one_way() -> None:
    rod = manifold3d.Manifold.cylinder(50.0, 4.0, 4.0, 64)
    (pin,) = pins(rod.translate((0.0, 0.0, -50.0)), rod, PROFILE)
    assert pin.flat
    above = pin.solid().trim_by_plane((0.0, 0.0, 1.0), 0.0)
    assert (above - pin.hole(PLAY)).is_empty()
    for angle in (30.0, 90.0, 180.0, 270.0):
        assert (above.rotate((0.0, 0.0, angle)) - pin.hole(PLAY)).volume() > 0.5


@pytest.mark.parametrize("size", [(4.0, 4.0), (100.0, 4.3)])
def test_where_walls_would_be_thinner_than_two_lines_there_is_no_pin(
    size: tuple[float, float],
) -> None:
    # A pin of 1.25 with play 0.2 and walls 0.9 needs 2 * 2.35 = 4.7 mm.
    assert pins(*bar(*size), PROFILE) == ()


def test_a_hole_that_would_break_out_below_is_not_made() -> None:
    low, high = bar(40.0, 20.0)
    thin = high.trim_by_plane((0.0, 0.0, -1.0), -4.0)
    # Only the shortest pin, 2.5 mm with play 0.4 and wall 0.9, has 4 mm of room.
    assert {pin.length for pin in pins(low, thin, PROFILE)} <= {2.5}
    assert pins(low, high.trim_by_plane((0.0, 0.0, -1.0), -3.0), PROFILE) == ()


def test_pins_of_different_joints_stand_differently_far_apart() -> None:
    def apart(mark: int) -> float:
        thick, thin = pins(*bar(60.0, 20.0), PROFILE, mark=mark)
        return float(np.linalg.norm(thick.middle - thin.middle))

    # Each step is 1.5 mm, more than the twice 0.2 of play on both pins together.
    assert np.diff([apart(mark) for mark in range(4)]) == pytest.approx([-1.5] * 3)
