"""Ranges and limits that no joint can have are named and mended; those that one can have stay."""

from __future__ import annotations

import math
from typing import Any

import pytest

from morph.body.spec import spec_of


def limited(bench: Any, limit: str, kind: str = "revolute", *held: str, **more: str) -> Any:
    """Return the reading of a robot with two joints, of which the second has this limit."""
    good = '<limit lower="-1" upper="1" effort="10" velocity="5"/>'
    return bench.read(
        *(bench.link(name) for name in "abc"),
        bench.joint("good", "a", "b", "revolute", good),
        bench.joint("odd", "b", "c", kind, limit and f"<limit {limit}/>", *held, **more),
    )


@pytest.mark.parametrize(
    ("limit", "kind"),
    [
        ('lower="-3.1416" upper="3.1416" effort="10" velocity="5"', "revolute"),
        ('lower="0" upper="0.5" effort="1000" velocity="0.1"', "prismatic"),
        # One turn and a half to each side, as winches have.
        ('lower="-9.42" upper="9.42" effort="10" velocity="5"', "revolute"),
        ('effort="10" velocity="5"', "continuous"),
        ("", "continuous"),
        ('lower="0.5" upper="1" effort="10" velocity="5"', "revolute"),
    ],
)
def test_limits_that_a_joint_can_have_are_kept_without_a_word(
    bench: Any, limit: str, kind: str
) -> None:
    reading = limited(bench, limit, kind)
    assert reading.findings == ()
    values = dict(part.split("=") for part in limit.replace('"', "").split())
    joint = reading.robot.joint("odd")
    lower, upper = values.get("lower"), values.get("upper")
    assert joint.limits == (None if lower is None else (float(lower), float(upper)))
    assert joint.effort == (float(values["effort"]) if "effort" in values else None)
    assert joint.velocity == (float(values["velocity"]) if "velocity" in values else None)


def test_one_bound_alone_leaves_the_other_at_zero_as_urdf_says(bench: Any) -> None:
    # URDF, element limit: lower and upper are optional and 0 without a word.
    reading = limited(bench, 'upper="1" effort="1" velocity="1"')
    assert reading.findings == ()
    assert reading.robot.joint("odd").limits == (0.0, 1.0)


def test_bounds_that_are_exchanged_are_put_in_order(bench: Any) -> None:
    reading = limited(bench, 'lower="1.5" upper="-0.5" effort="1" velocity="1"')
    assert reading.stands("limit-range", "repaired", "joint", "odd")
    assert reading.robot.joint("odd").limits == (-0.5, 1.5)
    assert reading.robot.joint("good").limits == (-1.0, 1.0)


def test_equal_bounds_off_zero_are_named_and_do_not_pin_the_joint(bench: Any) -> None:
    reading = limited(bench, 'lower="0.5" upper="0.5" effort="1" velocity="1"')
    assert reading.stands("limit-range", "repaired", "joint", "odd")
    assert reading.robot.joint("odd").limits is None


def test_a_range_of_zero_in_a_robot_with_ranges_is_named(bench: Any) -> None:
    reading = limited(bench, 'lower="0" upper="0" effort="1" velocity="1"')
    assert reading.stands("limit-range", "repaired", "joint", "odd")
    # Whatever is made of it, no mass is lost.
    assert reading.robot.mass == 3.0


@pytest.mark.parametrize("bound", ["inf", "-inf", "nan", "1e999"])
def test_a_bound_that_is_not_finite_is_named_and_the_joint_moves_freely(
    bench: Any, bound: str
) -> None:
    reading = limited(bench, f'lower="-1" upper="{bound}" effort="1" velocity="1"')
    assert reading.stands("limit-absurd", "repaired", "joint", "odd")
    assert reading.robot.joint("odd").limits is None


def test_a_range_in_degrees_is_named_as_one(bench: Any) -> None:
    reading = limited(bench, 'lower="-90" upper="90" effort="1" velocity="1"')
    assert reading.stands("limit-absurd", "info", "joint", "odd")
    assert "degrees" in reading.the("limit-absurd").what


def test_a_slide_in_millimetres_is_named(bench: Any) -> None:
    reading = limited(bench, 'lower="0" upper="400" effort="1" velocity="1"', "prismatic")
    assert reading.stands("limit-absurd", "info", "joint", "odd")


@pytest.mark.parametrize("key", ["effort", "velocity"])
def test_a_limit_of_zero_is_named_and_does_not_stop_the_joint(bench: Any, key: str) -> None:
    other = {"effort": "velocity", "velocity": "effort"}[key]
    reading = limited(bench, f'lower="-1" upper="1" {key}="0" {other}="2"')
    assert reading.stands("limit-zero", "info", "joint", "odd")
    assert key in reading.the("limit-zero").what
    assert getattr(reading.robot.joint("odd"), key) is None
    assert getattr(reading.robot.joint("odd"), other) == 2.0


@pytest.mark.parametrize("value", ["-5", "1e9", "inf", "nan"])
@pytest.mark.parametrize("key", ["effort", "velocity"])
def test_a_limit_that_no_motor_has_is_named_and_not_used(bench: Any, key: str, value: str) -> None:
    reading = limited(bench, f'lower="-1" upper="1" {key}="{value}"')
    told = [finding for finding in reading.findings if finding.where.name == "odd"]
    assert [finding.code for finding in told] in (["limit-absurd"], ["limit-zero"])
    assert getattr(reading.robot.joint("odd"), key) is None


@pytest.mark.parametrize("key", ["damping", "friction"])
def test_friction_that_feeds_energy_is_left_out(bench: Any, key: str) -> None:
    held = f'<dynamics {key}="-0.5"/>'
    reading = limited(bench, 'lower="-1" upper="1" effort="1" velocity="1"', "revolute", held)
    assert reading.stands("limit-absurd", "repaired", "joint", "odd")
    assert key in reading.the("limit-absurd").what


def test_a_robot_whose_exporter_knew_no_ranges_still_moves(bench: Any) -> None:
    # Every joint has the range 0 to 0: that is no robot of welds, but one without ranges.
    none = '<limit lower="0" upper="0" effort="1" velocity="1"/>'
    reading = bench.read(
        *(bench.link(name) for name in "abc"),
        bench.joint("one", "a", "b", "revolute", none),
        bench.joint("two", "b", "c", "revolute", none),
    )
    assert {finding.where.name for finding in reading.of("limit-range")} == {"one", "two"}
    assert [joint.limits for joint in reading.robot.joints] == [None, None]


def test_a_limit_of_half_a_turn_in_degrees_and_in_radians_are_told_apart(bench: Any) -> None:
    for upper, told in ((math.pi, False), (180.0, True)):
        reading = limited(bench, f'lower="0" upper="{upper!r}" effort="1" velocity="1"')
        assert bool(reading.of("limit-absurd")) == told


@pytest.mark.parametrize("tiny", ["1e-300", "1e-20", "1e-16"])
def test_what_is_too_small_for_mujoco_is_nothing_and_it_is_said(bench: Any, tiny: str) -> None:
    # MuJoCo reads what is below 1e-15 as zero, and then refuses an empty range.
    reading = limited(bench, f'lower="0" upper="{tiny}" effort="{tiny}" velocity="1"')
    assert reading.stands("limit-range", "repaired", "joint", "odd")
    assert reading.stands("limit-zero", "info", "joint", "odd")
    spec_of(reading.robot).compile()
