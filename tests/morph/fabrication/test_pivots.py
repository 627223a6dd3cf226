"""Joints without a servo: where each is halved between its two links."""

from __future__ import annotations

import numpy as np
import pytest

from morph.body.load import load
from morph.fabrication.drawing import drawing
from morph.fabrication.off_the_shelf_parts import items
from morph.fabrication.skeletons import skeletons
from morph.print.skeleton import Skeleton


def grown(name: str) -> dict[str, Skeleton]:
    body = drawing(load(name))
    found, _ = items(body)
    return skeletons(body, found)


def test_a_pole_hangs_beside_its_cart_on_the_side_where_the_cart_is_not() -> None:
    found = grown("cartpole")
    (cart,), (pole,) = found["cart"].pivots, found["pole"].pivots
    # The cart's box is at y of 10 to 70 mm, the pole's rod at -9 to 9 mm.
    assert (cart.side, pole.side) == (-1, 1)
    assert pole.axis == pytest.approx([0.0, -1.0, 0.0])
    assert cart.position == pytest.approx(np.zeros(3))
    assert cart.bearing == pole.bearing == "623"


def test_a_rod_of_a_four_bar_is_pinned_where_its_plane_and_the_levers_meet() -> None:
    found = grown("quadruped_four_bar")
    rod, thigh = found["front_left_hip_rod"], found["front_left_thigh"]
    far = max(rod.pivots, key=lambda pivot: float(pivot.position[0]))
    # The thigh's lever is 5 mm thick about y = 0 and the rod 3 mm about y = 10 in the thigh's
    # frame, so between y = 5 and 7; the rod's own frame is 10 mm to the side.
    assert far.position == pytest.approx([33.0, 6.0 - 10.0, 4.0], abs=0.05)
    other = next(pivot for pivot in thigh.pivots if abs(pivot.position[2] - 34.0) < 1.0)
    assert other.position == pytest.approx([-4.0, 6.0, 34.0], abs=0.05)
    assert {far.side, other.side} == {1, -1}
    assert far.bearing == other.bearing == "M2"


def test_what_a_servo_turns_has_a_horn_and_no_pivot() -> None:
    found = grown("so101")
    assert all(not each.pivots for each in found.values())
    assert [len(each.horns) for each in found.values()] == [0, 1, 1, 1, 1, 1, 1]
    assert [len(each.servos) for each in found.values()] == [1, 1, 1, 1, 1, 1, 0]


def test_feet_on_a_bought_board_hold_the_pivot_of_the_ankle() -> None:
    found = grown("rider_two_links_passive")
    assert set(found) == {"feet", "legs", "upper_body"}
    assert [pivot.side for pivot in found["feet"].pivots] == [-1]
    # The ankle is 123.76 mm over the ground, the feet's frame 91 mm.
    assert found["feet"].pivots[0].position == pytest.approx([0.0, 0.0, 32.76], abs=0.01)
