from __future__ import annotations

import itertools

import numpy as np
import pytest
import trimesh

from morph.print.gate import check_part
from morph.print.gauge import NOTCH_MM, PLAYS_MM, THICK_MM, gauges
from morph.print.mesh import Mesh
from morph.print.part import Part, Placement, Seat
from morph.print.printer import PRINTERS, Profile, material, printer
from morph.print.servo import SERVOS

PROFILE = Profile(printer=printer("ender3"), material=material("pla"))


def box(*sides: float) -> Mesh:
    found = trimesh.creation.box(sides)
    return Mesh(vertices=np.array(found.vertices), faces=np.array(found.faces, dtype=np.int64))


def seat(holds: str, bore: float = 0.0, pocket: Mesh | None = None) -> Seat:
    up = np.array([0.0, 0.0, 1.0])
    return Seat(holds=holds, position=np.zeros(3), axis=up, bore_mm=bore, pocket=pocket)


def holder(*seats: Seat, kind: str = "printed") -> Part:
    here = Placement(link="link", pose=np.eye(4), world=np.eye(4))
    return Part(name="p", kind=kind, mesh=box(9, 9, 9), placements=(here,), seats=seats)  # type: ignore[arg-type]


def openings(gauge: Part) -> list[np.ndarray]:
    """Sizes of the holes across a gauge, in mm, along x, notches left out."""
    assert gauge.mesh is not None
    middle = gauge.mesh.bounds.mean(axis=0)
    across = gauge.mesh.trimesh.section(plane_origin=middle, plane_normal=[0, 0, 1])
    flat, _ = across.to_2D(to_2D=np.diag([1.0, 1.0, 1.0, 1.0]))
    (whole,) = flat.polygons_full
    holes = [np.array(ring.coords) for ring in whole.interiors]
    holes = sorted(holes, key=lambda ring: ring[:, 0].mean())
    return [np.ptp(ring, axis=0) for ring in holes]


@pytest.mark.parametrize("known", SERVOS, ids=lambda known: known.name)
def test_a_servo_has_four_openings_as_wide_as_its_case_and_twice_the_play(known: object) -> None:
    which = next(each for each in SERVOS if each is known)
    (gauge,) = gauges([holder(seat(which.name, pocket=box(30, 30, 30)))], PROFILE)
    found = openings(gauge)
    assert len(found) == 4
    for size, play in zip(found, PLAYS_MM, strict=True):
        assert size == pytest.approx([which.width_mm + 2 * play, which.length_mm + 2 * play])


def test_a_hole_of_a_screw_is_tried_about_the_play_that_the_parts_have() -> None:
    (gauge,) = gauges([holder(seat("M3", bore=2.6))], PROFILE)
    # The play is 0.2 mm: 2.6 mm is the second; each step of 0.1 mm is 0.2 mm in diameter.
    assert gauge.name == "gauge_m3_2_6"
    # A polygon of 24 sides is as wide as its circle along x and y.
    widths = [size[0] for size in openings(gauge)]
    assert widths == pytest.approx([2.4, 2.6, 2.8, 3.0], abs=0.001)


def test_a_bearing_has_half_the_play_on_each_side() -> None:
    (gauge,) = gauges([holder(seat("608", bore=22.2, pocket=box(30, 30, 30)))], PROFILE)
    assert [size[0] for size in openings(gauge)] == pytest.approx(
        [22.1, 22.2, 22.3, 22.4], abs=0.001
    )


def test_what_is_in_no_catalogue_has_the_outline_of_its_pocket() -> None:
    (gauge,) = gauges([holder(seat("cell", pocket=box(8.4, 12.4, 30)))], PROFILE)
    # Drawn with 0.2 mm of play, so 0.1 less and 0.1 and 0.2 more on each side.
    assert [size[0] for size in openings(gauge)] == pytest.approx([8.2, 8.4, 8.6, 8.8])


def test_the_number_of_notches_tells_the_play() -> None:
    (gauge,) = gauges([holder(seat("M3", bore=2.6))], PROFILE)
    assert gauge.mesh is not None
    # A line just inside the notched edge leaves the plate once for each notch: 1 + 2 + 3 + 4.
    y = gauge.mesh.bounds[0, 1] + NOTCH_MM / 2.0
    at = np.linspace(*gauge.mesh.bounds[:, 0], 4000)
    points = np.stack([at, np.full_like(at, y), np.full_like(at, THICK_MM / 2.0)], axis=1)
    inside = gauge.mesh.trimesh.contains(points[1:-1])
    gaps = np.flatnonzero(inside[:-1] & ~inside[1:])
    assert len(gaps) == 10
    centres = at[1:-1][gaps]
    groups = [len(list(group)) for _, group in itertools.groupby(centres // _pitch(gauge))]
    assert groups == [1, 2, 3, 4]


def _pitch(gauge: Part) -> float:
    assert gauge.mesh is not None
    return float(gauge.mesh.extent[0] / 4.0)


def test_seats_of_one_kind_have_one_gauge_and_bought_parts_none() -> None:
    first = holder(seat("M3", bore=2.6), seat("M3", bore=2.6), seat("M3", bore=3.4))
    bought = holder(seat("M5", bore=4.2), kind="bought")
    found = gauges([first, first, bought], PROFILE)
    assert [gauge.name for gauge in found] == ["gauge_m3_2_6", "gauge_m3_3_4"]


@pytest.mark.parametrize("which", PRINTERS, ids=lambda which: which.name)
def test_every_gauge_passes_the_gate_on_every_printer(which: object) -> None:
    seats = [seat(servo.name, pocket=box(40, 40, 40)) for servo in SERVOS]
    seats += [seat("608", bore=22.2, pocket=box(22, 22, 9)), seat("M2", bore=1.7)]
    seats += [seat("plank", pocket=box(60, 30, 9)), seat("M8", bore=9.0)]
    profile = Profile(
        printer=next(each for each in PRINTERS if each is which), material=material("pla")
    )
    for gauge in gauges([holder(*seats)], profile):
        _, checks = check_part(gauge, profile)
        assert {check.verdict for check in checks} == {"passed"}, gauge.name
