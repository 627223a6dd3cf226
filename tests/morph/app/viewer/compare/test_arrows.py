"""Arrows: one scale for a kind, by what each body can bear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from morph.app.viewer.compare.arrows import Felt, arrows, said, scales, size_of
from morph.app.viewer.compare.forces import Drive, Forces
from morph.app.viewer.figure import figure
from morph.app.viewer.motion import posed
from morph.arrays import Array
from morph.body.load import load

NONE = np.zeros((3, 0, 2, 3))


def felt(
    newtons: Sequence[float], *, weight: float = 10.0, size: float = 1.0, limit: float | None = 4.0
) -> Felt:
    """A body that a contact pushes upward at (1, 0, 0), and whose one motor gives as much."""
    pushed = np.zeros((len(newtons), 1, 2, 3))
    pushed[:, 0, 0, 0] = 1.0
    pushed[:, 0, 1, 2] = newtons
    drive = Drive(joint="a", dof=0, place=0, index=0, unit="N m", limit=limit)
    return Felt(
        forces=Forces(
            drives=(drive,),
            effort=np.array(newtons, dtype=float)[:, None],
            contact=pushed,
            fluid=NONE,
            buoyancy=NONE,
            torque=pushed,
        ),
        weight=weight,
        size=size,
    )


def ends(drawn: Array) -> list[float]:
    """How long arrows are that point upward, m."""
    return [float(each) for each in (drawn[:, 0, 1, 2] - drawn[:, 0, 0, 2])]


def test_a_strong_force_is_half_as_long_as_its_body_is_large_and_the_others_in_proportion() -> None:
    body = felt([2.0, 2.0, 1.0], weight=10.0, size=3.0)
    full = scales([body])
    # 2 of 10 N: 20 %, already a round number. 2 of 4 N m: 50 %.
    assert full == pytest.approx({"contact": 0.2, "torque": 0.5})
    drawn = arrows(body, full)
    assert ends(drawn["contact"]) == pytest.approx([1.5, 1.5, 0.75])
    assert ends(drawn["torque"]) == pytest.approx([1.5, 1.5, 0.75])
    assert drawn["contact"][0, 0, 0] == pytest.approx([1.0, 0.0, 0.0])


def test_a_small_body_that_bears_its_weight_is_drawn_like_a_large_one_by_its_size() -> None:
    large, small = felt([700.0] * 3, weight=700.0, size=2.0), felt([7.0] * 3, weight=7.0, size=0.2)
    full = scales([large, small])
    assert full["contact"] == pytest.approx(1.0)
    assert ends(arrows(large, full)["contact"])[0] == pytest.approx(1.0)
    assert ends(arrows(small, full)["contact"])[0] == pytest.approx(0.1)


def test_scales_are_round_and_no_strong_force_is_longer_than_half_the_size() -> None:
    for newtons in (0.31, 1.7, 4.4, 17.0):
        full = scales([felt([newtons] * 3)])["contact"]
        assert f"{full:.0e}"[0] in "125"
        assert full == pytest.approx(float(f"{full:.0e}"), rel=1e-9)
        assert newtons / 10.0 <= full < 2.51 * newtons / 10.0


def test_a_blow_is_cut_and_what_is_next_to_nothing_is_left_out() -> None:
    body = felt([2.0, 2.0, 2.0, 2.0, 500.0, 0.01])
    found = ends(arrows(body, scales([body]))["contact"])
    # Of 2 N, 0.5 m; 500 N would be 125 m, and is cut to 1.5 m; 0.01 N would be 2.5 mm.
    assert found[0] == pytest.approx(0.5)
    assert found[4] == pytest.approx(1.5)
    assert np.isnan(found[5])


def test_a_contact_that_is_not_there_has_no_arrow() -> None:
    body = felt([2.0, np.nan, 2.0])
    found = ends(arrows(body, {"contact": 0.2})["contact"])
    assert np.isnan(found[1])
    assert found[2] == pytest.approx(0.5)


def test_a_motor_without_a_limit_is_measured_by_the_most_that_it_gave() -> None:
    body = felt([3.0, -3.0, 1.5], limit=None)
    assert scales([body])["torque"] == pytest.approx(1.0)
    assert ends(arrows(body, {"torque": 1.0})["torque"]) == pytest.approx([0.5, -0.5, 0.25])


def test_without_forces_there_is_nothing_to_draw() -> None:
    still = felt([0.0, 0.0, 0.0])
    assert scales([still]) == {}
    assert scales([]) == {}
    assert arrows(still, {}) == {}


def test_what_a_length_means_is_told_in_words() -> None:
    assert said({"contact": 1.0, "fluid": 0.005, "torque": 0.2, "buoyancy": 2.0}) == {
        "contact": "half the body's size is the body's weight",
        "fluid": "half the body's size is 0.5 % of the body's weight",
        "torque": "half the body's size is 20 % of the motor's limit",
        "buoyancy": "half the body's size is 2 times the body's weight",
    }


def test_a_body_is_as_large_as_the_box_around_what_moves() -> None:
    drawn = figure(load("cartpole"))
    still = posed(drawn.model, drawn.model.qpos0[None])
    # A pole of some 0.6 m on a cart of some 0.2 m; the rail, of 2 m or more, is the world's.
    assert 0.3 < size_of(drawn, still) < 1.0
