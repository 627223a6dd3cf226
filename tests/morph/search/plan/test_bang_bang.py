"""Commands that switch are at a bound but where they switch, and rest thereafter."""

from __future__ import annotations

import numpy as np
import pytest

from morph.search.plan.bang_bang import MOST_SWITCHES, Switches, drawn


def switching(durations: list[float], level: float) -> Switches:
    given = durations + [0.0] * (MOST_SWITCHES + 1 - len(durations))
    return Switches(duration=np.array([[given]]), level=np.array([[level]]))


def test_a_switch_within_a_period_is_averaged() -> None:
    # 0.12 s at +10, then 0.1 s at -10: the third period is 0.02 s up and 0.03 s down, -2; the
    # fifth 0.02 s down and 0.03 s at rest, -4.
    told = switching([0.12, 0.1], 1.0).commands(
        np.array([-10.0]), np.array([10.0]), period=0.05, periods=6
    )
    assert told[0, :, 0] == pytest.approx([10.0, 10.0, -2.0, -10.0, -4.0, 0.0])


def test_lopsided_bounds_are_reached_on_both_sides_and_rest_is_their_middle() -> None:
    told = switching([0.1, 0.1], -1.0).commands(
        np.array([-1.0]), np.array([3.0]), period=0.05, periods=5
    )
    assert told[0, :, 0] == pytest.approx([-1.0, -1.0, 3.0, 3.0, 1.0])


def test_no_draw_leaves_the_bounds_and_the_first_actuators_differ() -> None:
    rng = np.random.default_rng(0)
    high = np.array([20.0, 12.0])
    told = drawn(200, 2, 1.0, rng).commands(-high, high, period=0.05, periods=40)
    assert told.shape == (200, 40, 2)
    assert (np.abs(told) <= high + 1e-12).all()
    assert (told[:, 0, 0] > 0.0).any()
    assert (told[:, 0, 0] < 0.0).any()


def test_varied_times_keep_the_pieces_that_were_none() -> None:
    rng = np.random.default_rng(0)
    first = drawn(50, 1, 1.0, rng)
    varied = first.jittered(0.1, rng)
    assert ((varied.duration == 0.0) == (first.duration == 0.0)).all()
    assert (varied.duration != first.duration).any()
