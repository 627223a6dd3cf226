"""Bodies on one ground stand in nobody's way."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from morph.app.picture.shapes import PictureShape
from morph.app.viewer.content import Actor
from morph.app.viewer.layout import MOST_LETTERS, Layout, laid_out, title
from morph.app.viewer.layout_request import lanes_of
from morph.app.viewer.motion import RATE, MotionFrames
from morph.app.viewer.rows import gap, in_file, in_rows
from morph.app.viewer.swept_bounds import looked_at, matrices, room
from morph.arrays import Array

UP = np.array([0.0, 0.0, 3.0])
CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


def body(edges: Any, *, wet: bool = False, name: str = "box") -> Any:
    """Return a figure of one box with so long edges, m, that hangs on one link."""
    shape = PictureShape(
        body=1,
        vertices=CUBE * np.array(edges, dtype=float),
        faces=np.array([[0, 1, 2]]),
        colour=(1, 2, 3),
        opacity=1.0,
        flat=True,
    )
    model = SimpleNamespace(ngeom=0)
    return SimpleNamespace(shapes=(shape,), model=model, wet=wet, name=name, links=("world", "box"))


def going(way: Any, pictures: int = 5, up: float = 3.0) -> MotionFrames:
    """Return the motion of a box that goes by so much, m."""
    position = np.zeros((pictures, 2, 3))
    position[:, 1] = np.linspace(0.0, 1.0, pictures)[:, None] * np.array(way) + (0.0, 0.0, up)
    turn = np.zeros((pictures, 2, 4))
    turn[..., 0] = 1.0
    return MotionFrames(position=position, turn=turn)


def actor(edges: Any = (1.0, 1.0, 1.0), way: Any = (0.0, 0.0, 0.0), **more: Any) -> Actor:
    drawn = body(edges, wet=more.pop("wet", False), name=more.pop("name", "box"))
    return Actor(figure=drawn, motion=going(way, more.pop("pictures", 5)), **more)


def apart(layout: Layout, one: int, other: int) -> bool:
    low, high = layout.low, layout.high
    return bool(((low[one] >= high[other]) | (low[other] >= high[one]))[:2].any())


@given(seed=st.integers(0, 10_000))
def test_matrices_of_quaternions_are_those_of_scipy(seed: int) -> None:
    turns = Rotation.random(4, random_state=seed)
    ours = matrices(turns.as_quat(scalar_first=True).reshape(2, 2, 4))
    assert np.allclose(ours.reshape(4, 3, 3), turns.as_matrix(), atol=1e-14)


sizes = st.tuples(*(st.floats(0.02, 4.0),) * 3)
ways = st.tuples(st.floats(-30.0, 30.0), st.floats(-3.0, 3.0), st.just(0.0))


@settings(deadline=None, max_examples=25)
@given(given_=st.lists(st.tuples(sizes, ways), min_size=1, max_size=8))
def test_no_two_lanes_overlap_while_they_move(given_: list[tuple[Any, Any]]) -> None:
    actors = [actor(edges, way) for edges, way in given_]
    layout = laid_out(actors)
    assert all(apart(layout, i, j) for i in range(len(actors)) for j in range(i))


@settings(deadline=None, max_examples=15)
@given(given_=st.lists(sizes, min_size=1, max_size=8))
def test_every_body_stands_on_the_ground(given_: list[Any]) -> None:
    layout = laid_out([actor(edges) for edges in given_])
    # 3 m up, taken off again.
    assert np.allclose(layout.low[:, 2], 0.0, atol=1e-12)


def test_a_ghost_stands_where_its_original_does() -> None:
    layout = laid_out([actor(), actor(lane=0), actor(lane=0, ghost=True, title="")])
    assert np.array_equal(layout.places[1], layout.places[2])
    assert not np.array_equal(layout.places[0], layout.places[1])


def test_names_of_one_lane_stand_over_each_other() -> None:
    layout = laid_out([actor(lane=0, title="seen"), actor(lane=0, title="simulated")])
    assert layout.labels[1, 2] > layout.labels[0, 2]
    assert np.allclose(layout.labels[0, :2], layout.labels[1, :2])


def test_those_without_a_lane_come_after_those_with_one() -> None:
    assert lanes_of([actor(), actor(lane=1), actor(lane=1), actor()]) == [2, 1, 1, 3]


def test_those_that_go_past_others_go_side_by_side() -> None:
    layout = laid_out([actor(way=(20.0, 0.0, 0.0)), actor(way=(15.0, 0.0, 0.0))])
    low, high = layout.low[:, 1], layout.high[:, 1]
    assert high[0] < low[1]


def test_a_long_way_makes_the_picture_no_larger_while_the_camera_goes_along() -> None:
    stays = laid_out([actor()])
    goes = laid_out([actor(way=(50.0, 0.0, 0.0))])
    assert goes.radius == pytest.approx(stays.radius, rel=1e-9)


def test_the_room_of_a_turned_box_holds_its_corners() -> None:
    turn = Rotation.from_euler("xyz", (0.4, 0.5, 0.6))
    motion = going((0.0, 0.0, 0.0))
    motion.turn[:, 1] = turn.as_quat(scalar_first=True)
    found = room(Actor(figure=body((1.0, 2.0, 3.0)), motion=motion), np.arange(5))
    corners = turn.apply(CUBE * (1.0, 2.0, 3.0)) + np.array([0.0, 0.0, 3.0])
    # The first box is tight; of the others the box of a box is, whose corners are these too.
    assert np.allclose(found.low, corners.min(axis=0))
    assert np.allclose(found.high, corners.max(axis=0))


def test_shorter_motions_rest_while_longer_ones_go_on() -> None:
    short = Actor(figure=body((1, 1, 1)), motion=going((1.0, 0.0, 0.0), pictures=3))
    long = Actor(figure=body((1, 1, 1)), motion=going((1.0, 0.0, 0.0), pictures=601))
    pictures = looked_at([short, long])
    assert pictures[-1] == 600
    assert room(short, pictures).gone[-1, 0] == pytest.approx(1.0)


def test_a_body_in_water_hangs_over_the_ground() -> None:
    layout = laid_out([actor(wet=True)])
    # By 0.15 of its diagonal, sqrt(3) m.
    assert layout.low[0, 2] == pytest.approx(0.15 * 3**0.5)


def test_rows_are_read_from_the_back_to_the_front_and_from_the_left() -> None:
    low, high = np.full((4, 3), -0.5), np.full((4, 3), 0.5)
    found = in_rows(low, high, np.ones(4), np.zeros(4), 2)
    assert found[0, 0] < found[1, 0]
    assert found[0, 1] == found[1, 1] > found[2, 1] == found[3, 1]


@given(size=st.floats(0.1, 9.0), other=st.floats(0.1, 9.0))
def test_neighbours_in_a_file_keep_their_gap(size: float, other: float) -> None:
    half = 0.5 * np.array([[size] * 3, [other] * 3])
    found = in_file(-half, half, np.array([size, other]), np.zeros(2))
    between = (found[1, 1] - half[1, 1]) - (found[0, 1] + half[0, 1])
    assert between == pytest.approx(gap(size, other))


def test_a_wide_name_takes_room() -> None:
    half = np.full((2, 3), 0.05)
    narrow: Array = in_rows(-half, half, np.full(2, 0.1), np.zeros(2), 1)
    wide: Array = in_rows(-half, half, np.full(2, 0.1), np.full(2, 1.0), 1)
    # Centres 0.1 m and the gap apart, and then 1 m and the gap.
    assert np.diff(wide[:, 0])[0] - np.diff(narrow[:, 0])[0] == pytest.approx(0.9)


def test_a_long_name_is_cut_and_stays_on_one_line() -> None:
    told = title(actor(title="one\ntwo " + 100 * "x"))
    assert told.startswith("one two x")
    assert len(told) == MOST_LETTERS


def test_a_motion_rests_where_its_numbers_end() -> None:
    motion = going((4.0, 0.0, 0.0))
    position = motion.position.copy()
    position[3:] = np.nan
    lost = MotionFrames(position=position, turn=motion.turn)
    assert lost.lost == 3 / RATE
    assert np.array_equal(lost.position[4], motion.position[2])
    assert motion.lost is None


def test_a_motion_that_never_was_a_number_stands_at_the_origin() -> None:
    lost = MotionFrames(position=np.full((3, 2, 3), np.nan), turn=np.full((3, 2, 4), np.nan))
    assert lost.lost == 0.0
    assert np.array_equal(lost.position, np.zeros((3, 2, 3)))
    assert np.array_equal(lost.turn[0, 0], (1.0, 0.0, 0.0, 0.0))


def test_a_name_comes_down_with_a_body_that_falls() -> None:
    falls = laid_out([actor(way=(0.0, 0.0, -0.5), pictures=121)])
    # Half a metre in 2 s; the name keeps the height of 0.4 s before, a tenth of a metre.
    assert falls.rise[0, 0] == 0.0
    assert -0.5 < falls.rise[-1, 0] < -0.5 + 2.0 * 0.1
    assert (np.diff(falls.rise[:, 0]) <= 1e-12).all()


def test_a_body_is_not_hidden_by_its_neighbour_while_it_moves() -> None:
    # One goes 4 m while the other stays: from ahead and from behind it is looked at in between.
    layout = laid_out([actor(), actor(way=(4.0, 0.0, 0.0), pictures=61)])
    toward = layout.towards[:2] / np.linalg.norm(layout.towards[:2])
    across = np.array([-toward[1], toward[0]])
    apart_by = np.abs((layout.places[1] - layout.places[0])[:2] @ across)
    # Two cubes seen at an angle are at most sqrt(2) m wide: they begin clear of each other.
    assert apart_by > 0.5 * 2**0.5


def test_a_rail_beyond_what_its_cart_uses_makes_the_picture_no_larger() -> None:
    cart = body((0.2, 0.1, 0.1))
    rail = dataclasses.replace(cart.shapes[0], body=0, vertices=CUBE * (40.0, 0.02, 0.02) + UP)
    cart.shapes = (rail, *cart.shapes)
    found = laid_out([Actor(figure=cart, motion=going((0.0, 0.0, 0.0)))])
    # The cart's diagonal is 0.245 m; 0.3 of it is seen of the rail on either side.
    assert np.ptp(found.seen[:, 0]) == pytest.approx(0.2 + 2.0 * 0.3 * 0.06**0.5)
    # Its room is as long as the rail all the same: nobody else stands in it.
    assert found.high[0, 0] - found.low[0, 0] == pytest.approx(40.0)


def test_those_of_a_race_begin_beside_each_other() -> None:
    layout = laid_out([actor(way=(9.0, 0.0, 0.0)), actor(way=(30.0, 0.0, 0.0))])
    assert layout.places[0, 0] == layout.places[1, 0]


def test_a_name_stands_above_the_far_edge_of_its_body() -> None:
    layout = laid_out([actor((1.0, 2.0, 0.2))])
    forward = -layout.towards
    up = np.array([0.0, 0.0, 1.0]) - forward[2] * forward
    box = np.stack((layout.low[0], layout.high[0]))
    corners = np.array([[box[i, 0], box[j, 1], box[k, 2]] for i, j, k in np.ndindex(2, 2, 2)])
    assert layout.labels[0] @ up > (corners @ up).max()
