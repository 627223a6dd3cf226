"""Commands stay within their bounds, and feedback is left its room."""

from __future__ import annotations

import math

import numpy as np
import pytest

from morph.body.load import load
from morph.errors import PolicyError
from morph.policy.bound import SQUASHES, bound_of, limits, sine
from morph.policy.policy import Action, actions_of

LOPSIDED = (
    Action(actuator="a", unit="N", low=-1.0, high=3.0),
    Action(actuator="b", unit="rad", low=0.5, high=0.5),
)


def test_the_sine_squash_is_the_published_one_with_two_sines() -> None:
    x = np.linspace(-20.0, 20.0, 1001)
    assert sine(x) == pytest.approx((9.0 * np.sin(x) + np.sin(3.0 * x)) / 8.0, abs=1e-14)


@pytest.mark.parametrize("how", ["sine", "tanh"])
def test_squashed_commands_fill_the_range_about_its_middle(how: str) -> None:
    bound = bound_of(LOPSIDED, how, where="")
    # At pi / 2 the sine squash is 1; tanh is 1 - 2 exp(-40) at 20.
    far = math.pi / 2.0 if how == "sine" else 20.0
    told = bound(np.array([[0.0, 0.0], [far, far], [-far, -far]]))
    assert told == pytest.approx(np.array([[1.0, 0.5], [3.0, 0.5], [-1.0, 0.5]]), abs=1e-12)


@pytest.mark.parametrize("how", ["sine", "tanh"])
def test_a_squash_has_the_slope_of_a_smooth_function_everywhere(how: str) -> None:
    bound = bound_of(LOPSIDED[:1], how, where="")
    x, h = np.linspace(-4.0, 4.0, 401)[:, None], 1e-5
    slope = (bound(x + h) - bound(x - h)) / (2.0 * h)
    # Half the range, 2, times (3 cos s - 3 s^2 cos) / 2 for the sine; clipping jumps instead.
    s = np.sin(x)
    known = 3.0 * np.cos(x) * (1.0 - s**2) if how == "sine" else 2.0 / np.cosh(x) ** 2
    assert slope == pytest.approx(known, abs=1e-6)


def test_clipped_commands_are_what_they_were_between_their_bounds() -> None:
    bound = bound_of(LOPSIDED, "clip", where="")
    told = bound(np.array([[2.0, 0.5], [9.0, 9.0], [-9.0, -9.0]]))
    assert told.tolist() == [[2.0, 0.5], [3.0, 0.5], [-1.0, 0.5]]


def test_a_plan_within_a_margin_leaves_feedback_room_on_both_sides() -> None:
    low, high = limits(LOPSIDED, 0.1)
    # A range of 4 about 1: a tenth of its half, 0.2, is left at either end.
    assert low == pytest.approx([-0.8, 0.5])
    assert high == pytest.approx([2.8, 0.5])
    bound = bound_of(LOPSIDED, "clip", where="")
    assert bound(high + 0.1)[0] - bound(high - 0.1)[0] == pytest.approx(0.2)
    whole = limits(LOPSIDED)[1]
    assert bound(whole + 0.1)[0] - bound(whole - 0.1)[0] == pytest.approx(0.1)


@pytest.mark.parametrize("margin", [-0.1, 1.0, math.nan])
def test_a_margin_that_leaves_no_plan_is_refused(margin: float) -> None:
    with pytest.raises(PolicyError, match="margin of"):
        limits(LOPSIDED, margin)


def test_an_unknown_bound_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(PolicyError, match="its bound is 'wrap'") as caught:
        bound_of(LOPSIDED, "wrap", where="here")
    assert all(name in caught.value.fix for name in SQUASHES)


def test_what_has_no_bounds_is_not_squashed_into_them() -> None:
    legs = actions_of(load("hexapod_swimmer"))
    with pytest.raises(PolicyError, match="nothing limits left_front"):
        bound_of(legs, "sine", where="")
    assert bound_of(legs, "clip", where="")(np.full(6, 30.0)).tolist() == [30.0] * 6
