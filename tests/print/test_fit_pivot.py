from __future__ import annotations

import numpy as np
import pytest

from morph.print.bearing import BEARINGS, bearing
from morph.print.errors import SeatError
from morph.print.fit_pivot import GAP_MM, axle
from morph.print.mesh import Mesh, from_manifold
from morph.print.printer import Profile, material, printer
from morph.print.shell import Shell, shell
from morph.print.skeleton import Pivot, Skeleton
from morph.print.solid import box, frame, placed, rod

PROFILE = Profile(printer=printer("mk4"), material=material("pla"))


def half(side: int, bearing_name: str, along: int) -> Shell:
    """A bar of 16 by 16 mm that passes through the axle, as drawings have it."""
    low, high = np.full(3, -8.0), np.full(3, 8.0)
    high[along] = 90.0
    bar: Mesh = from_manifold(box(tuple(low), tuple(high)))
    joint = Pivot(
        position=np.zeros(3), axis=np.array([0.0, 1.0, 0.0]), side=side, bearing=bearing_name
    )
    return shell(Skeleton(name="bar", solids=(bar,), pivots=(joint,)), PROFILE)


@pytest.mark.parametrize("name", ["M2", *(each.name for each in BEARINGS)])
def test_the_halves_of_a_lap_joint_turn_in_each_other(name: str) -> None:
    still, moving = half(-1, name, 2).mesh.manifold, half(1, name, 2).mesh.manifold
    for angle in (20.0, 60.0, 130.0, 180.0, 275.0):
        turned = moving.rotate([0.0, angle, 0.0])
        near = turned ^ _about(axle(name).radius_mm + 0.4)
        # Within the room of the boss there is half a gap on each side.
        assert (near ^ still).volume() == pytest.approx(0.0, abs=1e-6)
        assert near.min_gap(still ^ _about(axle(name).radius_mm + 0.4), 5.0) == pytest.approx(
            GAP_MM, abs=1e-6
        )


def test_bars_that_lie_side_by_side_turn_all_the_way() -> None:
    def bar(side: int) -> Shell:
        y = (0.3, 8.0) if side > 0 else (-8.0, -0.3)
        solid = from_manifold(box((-8.0, y[0], -8.0), (8.0, y[1], 90.0)))
        joint = Pivot(
            position=np.zeros(3), axis=np.array([0.0, 1.0, 0.0]), side=side, bearing="623"
        )
        return shell(Skeleton(name="bar", solids=(solid,), pivots=(joint,)), PROFILE)

    still, moving = bar(-1).mesh.manifold, bar(1).mesh.manifold
    for angle in np.arange(0.0, 360.0, 24.0):
        assert (moving.rotate([0.0, float(angle), 0.0]) ^ still).volume() == pytest.approx(
            0.0, abs=1e-6
        )


def test_a_bearing_goes_into_its_seat_and_its_screw_through_it() -> None:
    part = half(-1, "623", 2).mesh.manifold
    which = bearing("623")
    # From the gap's face inward, against the axis.
    pose = frame(np.array([0.0, -GAP_MM / 2, 0.0]), np.array([0.0, -1.0, 0.0]))
    ring = placed(rod(which.outer_mm / 2, 0.0, which.width_mm), pose)
    assert (ring ^ part).volume() == pytest.approx(0.0, abs=1e-6)
    # Behind it a floor holds it, and the way of its screw is free.
    behind = placed(rod(which.outer_mm / 2, which.width_mm, which.width_mm + 1.0), pose)
    assert (behind ^ part).volume() > 0.5 * behind.volume()
    assert (placed(rod(1.5, 0.0, 50.0), pose) ^ part).volume() == pytest.approx(0.0, abs=1e-6)


def test_wheels_on_one_axis_leave_each_other_their_boss() -> None:
    bar = from_manifold(box((-6.0, -50.0, -6.0), (6.0, 50.0, 6.0)))
    joints = tuple(
        Pivot(
            position=np.array([0.0, y, 0.0]), axis=np.array([0.0, 1.0, 0.0]), side=-1, bearing="623"
        )
        for y in (-40.0, 40.0)
    )
    grown = shell(Skeleton(name="axle", solids=(bar,), pivots=joints), PROFILE)
    assert [seat.holds for seat in grown.seats] == ["623", "623"]
    assert len(grown.mesh.manifold.decompose()) == 1


def test_an_unknown_bearing_is_named() -> None:
    with pytest.raises(SeatError, match="9999"):
        axle("9999")


def _about(radius: float) -> object:
    return placed(rod(radius, -60.0, 60.0), frame(np.zeros(3), np.array([0.0, 1.0, 0.0])))
