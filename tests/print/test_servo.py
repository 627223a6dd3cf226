from __future__ import annotations

import math

import numpy as np
import pytest

from morph.body.servo import SERVOS as MOTORS
from morph.print.errors import SeatError
from morph.print.mesh import Mesh
from morph.print.screw import screw
from morph.print.servo import (
    SERVOS,
    ServoSize,
    body,
    case,
    disc_radius,
    horn_disc,
    horn_pattern,
    pocket,
    screw_holes,
    servo,
)

EVERY = pytest.mark.parametrize("which", SERVOS, ids=lambda each: each.name)


SIZELESS = {
    "XL330-M288", "XL430-W250", "XM430-W350", "XM540-W270", "MX-106", "MG996R", "SCS15", "STS3250",
    "GO1-HIP", "RMD-X8",
}  # fmt: skip
"""Servos whose sizes nobody wrote down yet: their joints get room, but no horn, and it is said."""


def test_every_other_motor_that_a_card_may_name_has_a_size() -> None:
    assert {motor.name for motor in MOTORS} - {each.name for each in SERVOS} == SIZELESS


@EVERY
def test_a_case_is_as_large_as_its_sides(which: ServoSize) -> None:
    sides = which.length_mm * which.width_mm * which.height_mm
    if which.flange is not None:
        over = which.flange.length_mm - which.length_mm
        sides += over * which.width_mm * which.flange.thickness_mm
    assert case(which).volume == pytest.approx(sides, rel=1e-9)
    near, far = case(which).bounds[:, 0]
    middle = which.length_mm / 2 - which.axis_mm
    assert near + far == pytest.approx(2 * middle, abs=1e-9)
    assert case(which).bounds[1, 2] == 0.0


@EVERY
@pytest.mark.parametrize("side", ["+z", "+y", "-y"])
def test_a_pocket_lets_the_servo_in_from_its_open_side(which: ServoSize, side: str) -> None:
    room = pocket(which, 0.2, side).manifold  # type: ignore[arg-type]
    way = {"+z": (0, 0, 1), "+y": (0, 1, 0), "-y": (0, -1, 0)}[side]
    depth = which.height_mm if side == "+z" else which.width_mm
    for out in np.linspace(0.0, depth, 7):
        moved = case(which).manifold.translate([float(out * x) for x in way])
        # 0.2 mm of play on each side: nothing of the case is outside of the room.
        assert (moved - room).volume() == pytest.approx(0.0, abs=1e-6)


@EVERY
def test_the_horn_turns_in_the_pocket(which: ServoSize) -> None:
    turned = horn_disc(which).rotate([0, 0, 37.0])
    assert (turned - pocket(which, 0.2).manifold).volume() == pytest.approx(0.0, abs=1e-6)
    assert disc_radius(which) >= which.horn.diameter_mm / 2


@EVERY
def test_a_horns_holes_are_in_its_disc_and_apart(which: ServoSize) -> None:
    disc, holes = horn_disc(which), horn_pattern(which, 0.2).manifold
    left = disc - holes
    # One piece: no hole cuts the rim off.
    assert len(left.decompose()) == 1
    assert left.volume() < disc.volume()
    if which.horn.count:
        apart = which.horn.circle_mm * math.sin(math.pi / which.horn.count)
        assert apart - screw(which.horn.screw).clear_mm > 0.8
        rim = disc_radius(which) - which.horn.circle_mm / 2 - screw(which.horn.screw).clear_mm / 2
        assert rim > 0.8


@EVERY
def test_screws_meet_the_case_or_its_rim_and_not_the_wires(which: ServoSize) -> None:
    holes = screw_holes(which, 2.4)
    assert (holes is None) == (which.held_by == "strap")
    low, high, half = which.wires_mm
    for x, y in which.holes_mm:
        wires = low - 1.0 < x < high + 1.0 and abs(y) < half + 0.5
        assert which.held_by == "rim" or not wires
    if holes is not None and which.held_by == "floor":
        assert (holes.manifold ^ case(which).manifold).volume() > 0


@EVERY
def test_all_of_a_servo_is_its_case_and_its_horn(which: ServoSize) -> None:
    whole: Mesh = body(which)
    assert whole.volume > case(which).volume
    assert whole.bounds[1, 2] >= which.horn.top_mm


def test_servos_are_as_heavy_as_plastic_and_metal_are() -> None:
    # Between wood (0.6 g/cm3) and aluminium (2.7 g/cm3): a slip of a digit would show.
    for which in SERVOS:
        density = 1e6 * which.mass / case(which).volume
        assert 0.6 < density < 2.7, which.name


def test_an_unknown_servo_is_named_with_those_there_are() -> None:
    assert servo("mx-28").name == "MX-28"
    with pytest.raises(SeatError, match=r"MX-29.*STS3215.*SG90"):
        servo("MX-29")
