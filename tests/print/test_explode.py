from __future__ import annotations

import itertools

import numpy as np
import pytest
import trimesh

from morph.print.explode import Explosion, carried, exploded
from morph.print.mesh import Mesh
from morph.print.part import Hinge, Part, Placement, Seat


def block(size: float = 10.0) -> Mesh:
    box = trimesh.creation.box((size, size, size))
    return Mesh(vertices=np.array(box.vertices), faces=np.array(box.faces, dtype=np.int64))


def part(name: str, *places: tuple[str, tuple[float, float, float]], **more: object) -> Part:
    placements = []
    for link, at in places:
        world = np.eye(4)
        world[:3, 3] = at
        placements.append(Placement(link=link, pose=np.eye(4), world=world))
    given = {"kind": "printed", "mesh": block()} | more
    return Part(name=name, placements=tuple(placements), **given)  # type: ignore[arg-type]


def hinge(still: str, moving: str) -> Hinge:
    return Hinge(
        name=f"{still}_{moving}",
        kind="hinge",
        position=np.zeros(3),
        axis=np.array([0.0, 1.0, 0.0]),
        low=-1.0,
        high=1.0,
        still=still,
        moving=moving,
    )


def gaps(parts: list[Part], told: Explosion, factor: float) -> list[float]:
    """How far boxes are apart along the axis in which they are farthest apart, mm."""
    boxes = []
    for each in parts:
        for copy in range(each.count if each.mesh else 0):
            moved = each.mesh.moved(told.pose(each, copy, factor))  # type: ignore[union-attr]
            boxes.append(moved.bounds)
    return [
        float(np.maximum(a[0] - b[1], b[0] - a[1]).max())
        for a, b in itertools.combinations(boxes, 2)
    ]


# Two legs on a trunk, each with a foot that sits within it; a servo in the trunk, wholly.
SERVO = Seat(
    holds="SG90", position=np.zeros(3), axis=np.array([0.0, 0.0, 1.0]), bore_mm=0.0, pocket=None
)
BODY = [
    part("trunk", ("trunk", (0, 0, 0)), mesh=block(30.0), seats=(SERVO,)),
    part("leg", ("left", (0, 18, 0)), ("right", (0, -18, 0))),
    part("foot", ("left_foot", (0, 20, -3)), ("right_foot", (0, -20, -3))),
    part("servo", ("trunk", (0, 0, 2)), kind="bought"),
    part("screws", ("trunk", (0, 0, 0)), kind="bought", mesh=None),
]
HINGES = [
    hinge("trunk", "left"),
    hinge("trunk", "right"),
    hinge("left", "left_foot"),
    hinge("right", "right_foot"),
]


def test_no_two_parts_overlap_when_all_is_apart_and_all_do_before() -> None:
    told = exploded(BODY, HINGES)
    assert min(gaps(BODY, told, 0.0)) < 0.0
    # The room between is half of `APART` of the diagonal within a link: 52 mm / 40 = 1.3 mm.
    assert min(gaps(BODY, told, 1.0)) > 1.0


def test_a_leg_goes_outward_and_takes_its_foot_along() -> None:
    told = exploded(BODY, HINGES)
    left, foot = told.offsets["leg", 0], told.offsets["foot", 0]
    np.testing.assert_allclose(left[[0, 2]], 0.0, atol=1e-9)
    assert left[1] > 0.0
    assert foot[1] >= left[1]
    np.testing.assert_allclose(told.offsets["leg", 1], -left, atol=1e-9)


def test_what_was_bought_leaves_along_the_axis_of_its_seat() -> None:
    told = exploded(BODY, HINGES)
    # From z in [-3, 7] it must clear the trunk's top at 15 by half the gap of 5 % of the
    # diagonal of the whole body, 30 by 50 by 30 mm: 15 + 3 + 0.025 * 65.57 = 19.64.
    np.testing.assert_allclose(told.offsets["servo", 0], (0.0, 0.0, 19.64), atol=0.01)
    assert ("screws", 0) not in told.offsets


def test_nothing_moves_at_zero_and_half_is_half() -> None:
    told = exploded(BODY, HINGES)
    leg = BODY[1]
    np.testing.assert_array_equal(told.pose(leg, 0, 0.0), leg.placements[0].world)
    half = told.pose(leg, 0, 0.5)[:3, 3] - leg.placements[0].world[:3, 3]
    np.testing.assert_allclose(half, 0.5 * told.offsets["leg", 0])


def test_links_come_from_the_base_outward() -> None:
    links = exploded(BODY, HINGES).links
    assert links[0] == "trunk"
    assert set(links[1:3]) == {"left", "right"}


def test_a_closed_chain_is_taken_apart_once() -> None:
    parent = carried([hinge("a", "b"), hinge("b", "c"), hinge("c", "a"), hinge("a", "c")])
    assert parent == {"b": "a", "c": "b"}


@pytest.mark.parametrize("parts", [[], [part("alone", ("a", (0, 0, 0)), mesh=None)]])
def test_nothing_to_take_apart_is_no_fault(parts: list[Part]) -> None:
    assert exploded(parts, []).offsets == {}


def test_parts_in_the_same_place_and_without_a_joint_come_apart() -> None:
    parts = [part(name, (name, (0, 0, 0))) for name in "abcd"]
    assert min(gaps(parts, exploded(parts, []), 1.0)) > 0.5
