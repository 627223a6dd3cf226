"""Masses and inertias that are missing, or that no body has, are named and mended by known laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

WATER = 1000.0
"""What a shape without a mass is filled with, kg/m3."""


def moments(link: Any) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = link.inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def arm(bench: Any, link: str, kind: str = "continuous") -> Any:
    """Return the reading of a base that carries one more link, called arm."""
    return bench.read(bench.link("base"), link, bench.joint("j", "base", "arm", kind))


def test_good_masses_are_kept_to_the_last_bit(bench: Any) -> None:
    link = bench.link("arm", mass=0.7, moments=(0.3, 0.2, 0.15, 0.01, -0.02, 0.03))
    reading = arm(bench, link)
    assert reading.findings == ()
    assert reading.robot.link("arm").mass == 0.7
    # Through principal axes and back: a few roundings of 0.3.
    expected = [[0.3, 0.01, -0.02], [0.01, 0.2, 0.03], [-0.02, 0.03, 0.15]]
    assert moments(reading.robot.link("arm")) == pytest.approx(np.array(expected), abs=1e-14)


def test_a_link_that_moves_without_mass_takes_that_of_its_shape_in_water(bench: Any) -> None:
    reading = arm(bench, bench.link("arm", bench.box("0.1 0.2 0.3", "0 0 0.5"), mass=None))
    assert reading.stands("mass-missing", "repaired", "link", "arm")
    link = reading.robot.link("arm")
    mass = WATER * 0.1 * 0.2 * 0.3
    assert link.mass == pytest.approx(mass, rel=1e-12)
    assert link.com == pytest.approx((0.0, 0.0, 0.5), abs=1e-12)
    # A solid box: m / 12 (b^2 + c^2), and so on round.
    box = mass / 12 * np.diag((0.2**2 + 0.3**2, 0.1**2 + 0.3**2, 0.1**2 + 0.2**2))
    assert moments(link) == pytest.approx(box, rel=1e-12, abs=1e-15)
    assert link.inertia_from == "mesh x density"


def test_a_link_that_moves_without_mass_or_shape_gets_a_token_and_it_is_said(bench: Any) -> None:
    reading = arm(bench, '<link name="arm"/>')
    assert reading.stands("mass-missing", "repaired", "link", "arm")
    assert 0 < reading.robot.link("arm").mass < 1e-3
    assert reading.robot.link("arm").inertia_from == "none"


def test_a_shape_too_small_to_weigh_anything_is_no_shape(bench: Any) -> None:
    # A cube of a nanometre holds 1e-24 kg of water, and MuJoCo moves nothing below 1e-15.
    reading = arm(bench, bench.link("arm", bench.box("1e-9 1e-9 1e-9"), mass=None))
    assert reading.stands("mass-missing", "repaired", "link", "arm")
    assert reading.robot.link("arm").inertia_from == "none"


def test_a_frame_that_is_welded_on_needs_no_mass(bench: Any) -> None:
    reading = arm(bench, '<link name="arm"/>', "fixed")
    assert reading.findings == ()
    assert reading.robot.mass == 1.0


def test_a_link_without_mass_that_carries_a_welded_mass_is_one_body_with_it(bench: Any) -> None:
    reading = bench.read(
        bench.link("base"),
        '<link name="flange"/>',
        bench.link("tool", mass=2.0),
        bench.joint("turn", "base", "flange"),
        bench.joint("weld", "flange", "tool", "fixed"),
    )
    assert reading.findings == ()
    assert reading.robot.mass == 3.0


def test_a_welded_part_with_a_shape_and_no_mass_is_told_and_left(bench: Any) -> None:
    reading = arm(bench, bench.link("arm", bench.box(), mass=None), "fixed")
    assert reading.stands("mass-missing", "info", "link", "arm")
    assert reading.robot.mass == 1.0


def test_a_mass_of_zero_that_moves_is_a_missing_one(bench: Any) -> None:
    reading = arm(bench, bench.link("arm", mass=0.0, moments=(0.0, 0.0, 0.0)))
    assert reading.stands("mass-missing", "repaired", "link", "arm")


def test_a_negative_mass_is_never_simulated(bench: Any) -> None:
    shaped = arm(bench, bench.link("arm", bench.box("0.1 0.1 0.1"), mass=-2.0))
    assert shaped.stands("inertia-broken", "repaired", "link", "arm")
    assert shaped.robot.link("arm").mass == pytest.approx(WATER * 0.1**3, rel=1e-12)
    bare = arm(bench, bench.link("arm", mass=-2.0))
    assert bare.robot is None
    assert bare.stands("inertia-broken", "refused", "link", "arm")


def test_a_mass_without_an_inertia_takes_that_of_its_shape(bench: Any) -> None:
    shape = '<collision><geometry><cylinder radius="0.1" length="0.5"/></geometry></collision>'
    held = '<inertial><mass value="3"/></inertial>'
    reading = arm(bench, f'<link name="arm">{shape}{held}</link>')
    assert reading.stands("inertia-missing", "repaired", "link", "arm")
    # A solid cylinder: m r^2 / 2 along, m (3 r^2 + l^2) / 12 across.
    across = 3 * (3 * 0.1**2 + 0.5**2) / 12
    cylinder = np.diag((across, across, 3 * 0.1**2 / 2))
    assert reading.robot.link("arm").mass == 3.0
    assert moments(reading.robot.link("arm")) == pytest.approx(cylinder, rel=1e-12, abs=1e-15)


def test_a_mass_without_inertia_or_shape_is_a_ball_of_water(bench: Any) -> None:
    reading = arm(bench, bench.link("arm", mass=2.0, moments=(0.0, 0.0, 0.0)))
    assert reading.stands("inertia-missing", "repaired", "link", "arm")
    radius = (2.0 / WATER * 3 / (4 * math.pi)) ** (1 / 3)
    ball = 0.4 * 2.0 * radius**2 * np.eye(3)
    assert moments(reading.robot.link("arm")) == pytest.approx(ball, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize(
    "broken",
    [
        (0.1, 0.1, 0.3),  # 0.1 + 0.1 < 0.3
        (0.3, -0.1, 0.3),  # negative
        (0.1, 0.1, 0.1, 0.2),  # an off-diagonal above the diagonal: not positive definite
        (-0.1, -0.1, -0.1),  # nothing of it is of use
        (0.1, -0.1, 0.0),  # it adds up to nothing
        (0.0, 0.0, 0.0, 0.1),
    ],
)
def test_an_inertia_that_no_body_has_is_replaced_by_one_that_a_body_has(
    bench: Any, broken: tuple[float, ...]
) -> None:
    reading = arm(bench, bench.link("arm", moments=broken))
    assert reading.stands("inertia-broken", "repaired", "link", "arm")
    assert reading.robot.link("arm").mass == 1.0
    a, b, c = np.linalg.eigvalsh(moments(reading.robot.link("arm")))
    assert a > 0
    assert a + b >= c * (1 - 1e-12)


@pytest.mark.parametrize(
    "flat",
    [
        (0.1, 0.2, 0.3),  # a sheet: 0.1 + 0.2 = 0.3 but for rounding
        (1e-9, 0.2, 0.2),  # nearly a rod
        (0.02, 0.02, 0.02),
    ],
)
def test_an_inertia_at_the_edge_of_what_bodies_have_is_left_alone(
    bench: Any, flat: tuple[float, ...]
) -> None:
    reading = arm(bench, bench.link("arm", moments=flat))
    assert reading.findings == ()
    given = np.linalg.eigvalsh(moments(reading.robot.link("arm")))
    assert given == pytest.approx(sorted(flat), rel=1e-12)


def test_a_base_without_inertia_that_floats_is_mended_too(bench: Any) -> None:
    for base in ("floating", "board"):
        reading = bench.read(bench.link("trunk", bench.box(), mass=None), base=base)
        assert reading.stands("mass-missing", "repaired", "link", "trunk"), base
        assert reading.robot.mass == pytest.approx(WATER * 0.2**3, rel=1e-12)


def test_a_base_without_mass_that_is_bolted_needs_none(bench: Any) -> None:
    reading = bench.read(
        '<link name="stand"/>', bench.link("arm"), bench.joint("j", "stand", "arm")
    )
    assert reading.findings == ()
    assert reading.robot.mass == 1.0


def test_a_mass_of_the_world_is_told_and_not_lost(bench: Any) -> None:
    # MuJoCo's world holds no mass: the link gets another name and stands in the world.
    reading = bench.read(
        bench.link("world", mass=5.0), bench.link("arm"), bench.joint("j", "world", "arm")
    )
    assert reading.stands("duplicate-name", "repaired", "link", "world")
    assert reading.robot.mass == 6.0
