from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from morph.print.check.seat_fit import seat_fit
from morph.print.check.subject import Subject
from morph.print.mesh import Mesh
from morph.print.part import Seat

Make = Callable[..., Mesh]


def drilled(block: Mesh, diameter: float, depth: float) -> Mesh:
    """A block with a hole from its top, whose height is that of its box, along z."""
    top = block.bounds[1, 2]
    drill = trimesh.creation.cylinder(diameter / 2.0, 2.0 * depth, sections=64)
    drill.apply_translation([0.0, 0.0, top])
    found = trimesh.boolean.difference([block.trimesh, drill], engine="manifold")
    return Mesh(vertices=np.array(found.vertices), faces=np.array(found.faces))


def hole(diameter: float, up: float = 1.0) -> Seat:
    return Seat(
        holds="M3",
        position=np.array([0.0, 0.0, 10.0]),
        axis=np.array([0.0, 0.0, up]),
        bore_mm=diameter,
    )


def test_a_drilled_hole_holds_its_screw(box: Make, subject: Callable[..., Subject]) -> None:
    assert seat_fit(subject(drilled(box(20, 20, 20), 3.0, 8.0), hole(3.0))).verdict == "passed"


@pytest.mark.parametrize(
    ("drill", "depth", "seat", "said"),
    [
        # A chord of 64 lies 1.25 (1 - cos(pi / 64)) = 0.0015 mm inside: 2.5 mm to two figures.
        (2.5, 8.0, hole(3.0), "is 2.5 mm wide at 0.5 mm, and 3 mm is needed"),
        (3.0, 1.5, hole(3.0), "is 0 mm wide at 2 mm"),
        (19.0, 8.0, hole(3.0), "nothing around its hole of 3 mm"),
        (1.0, 8.0, hole(1.0), "a hole of 1 mm, and 1.2 mm is the least"),
        # Looked at from inside out there is plastic before it, and none at its sides.
        (3.0, 8.0, hole(3.0, up=-1.0), "nothing around its hole"),
    ],
)
def test_a_hole_that_does_not_do_is_told_with_its_size(
    drill: float,
    depth: float,
    seat: Seat,
    said: str,
    box: Make,
    subject: Callable[..., Subject],
) -> None:
    found = seat_fit(subject(drilled(box(20, 20, 20), drill, depth), seat))
    assert found.verdict == "refused"
    assert said in found.what


def test_a_hole_that_is_covered_is_refused(box: Make, subject: Callable[..., Subject]) -> None:
    lid = trimesh.boolean.union(
        [drilled(box(20, 20, 20), 3.0, 8.0).trimesh, box(20, 20, 1, at=(0, 0, 10.5)).trimesh],
        engine="manifold",
    )
    covered = Mesh(vertices=np.array(lid.vertices), faces=np.array(lid.faces))
    found = seat_fit(subject(covered, hole(3.0)))
    assert found.verdict == "refused"
    assert "its hole is closed" in found.what


def test_a_small_hole_is_to_be_drilled(box: Make, subject: Callable[..., Subject]) -> None:
    found = seat_fit(subject(drilled(box(20, 20, 20), 1.7, 8.0), hole(1.7)))
    assert (found.verdict, found.fix) == ("noted", "drill it after printing")


@pytest.mark.parametrize(
    ("pocket", "said"),
    [
        ((10.0, 10.0, 12.0), ""),
        # Wider by 2 mm on two sides, and 8 mm of it below the top: 2 * 2 * 10 * 8 = 320 mm3.
        ((14.0, 10.0, 12.0), "is filled by 320 mm3"),
    ],
)
def test_a_pocket_is_empty_or_told_by_how_much_it_is_filled(
    pocket: tuple[float, float, float],
    said: str,
    box: Make,
    subject: Callable[..., Subject],
) -> None:
    opened = trimesh.boolean.difference(
        [box(20, 20, 20).trimesh, box(10, 10, 12, at=(0, 0, 8)).trimesh], engine="manifold"
    )
    block = Mesh(vertices=np.array(opened.vertices), faces=np.array(opened.faces))
    seat = Seat(
        holds="cell",
        position=np.array([0.0, 0.0, 10.0]),
        axis=np.array([0.0, 0.0, 1.0]),
        bore_mm=0.0,
        pocket=box(*pocket, at=(0, 0, 8)),
    )
    found = seat_fit(subject(block, seat))
    assert found.verdict == ("refused" if said else "passed")
    assert said in found.what


def test_a_pocket_beside_the_part_is_held_by_nothing(
    box: Make, subject: Callable[..., Subject]
) -> None:
    seat = Seat(
        holds="cell",
        position=np.zeros(3),
        axis=np.array([0.0, 0.0, 1.0]),
        bore_mm=0.0,
        pocket=box(10, 10, 10, at=(40, 0, 0)),
    )
    found = seat_fit(subject(box(20, 20, 20), seat))
    assert found.verdict == "refused"
    assert "nothing around it that holds" in found.what
