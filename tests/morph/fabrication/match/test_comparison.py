"""What counts as holding."""

from __future__ import annotations

import numpy as np
import pytest

from morph.fabrication.match.comparison import ALLOWED, Comparison
from morph.search.evaluate import Score
from morph.task.task import UNSTABLE


def score(loss: float, failed: int = 0, rows: int = 100) -> Score:
    return Score(loss=np.full(rows, loss), success=np.arange(rows) >= failed)


@pytest.mark.parametrize(
    ("loss", "failed", "holds"),
    [(10.0, 0, True), (11.79, 0, True), (11.81, 0, False), (10.0, 2, True), (10.0, 3, False)],
)
def test_a_policy_holds_up_to_two_hundredths_of_what_there_is_to_lose(
    loss: float, failed: int, holds: bool
) -> None:
    # From 10 to the 100 of doing nothing are 90, of which 2 % are 1.8; 2 of 100 runs may fail.
    found = Comparison(designed=score(10.0), printed=score(loss, failed), still=score(100.0))
    assert found.span == pytest.approx(90.0)
    assert found.growth == pytest.approx((loss - 10.0) / 90.0)
    assert found.holds == holds


def test_where_doing_nothing_costs_less_the_span_is_the_loss_itself() -> None:
    found = Comparison(designed=score(10.0), printed=score(10.1), still=score(9.0))
    assert found.growth == pytest.approx(0.01)


def test_runs_that_nobody_could_simulate_widen_no_span() -> None:
    still = Score(loss=np.array([100.0, UNSTABLE]), success=np.zeros(2, bool))
    found = Comparison(designed=score(10.0), printed=score(20.0), still=still)
    assert found.span == pytest.approx(90.0)


def test_what_holds_may_still_be_worth_a_cheap_match() -> None:
    # Of a span of 9990, 10 to 30 is 0.2 %; of the loss itself it is 200 %.
    found = Comparison(designed=score(10.0), printed=score(30.0), still=score(10000.0))
    assert found.holds
    assert not found.close


def test_a_body_on_which_nothing_costs_anything_has_not_lost() -> None:
    nothing = score(0.0)
    assert Comparison(designed=nothing, printed=nothing, still=nothing).growth == 0.0
    lost = Comparison(designed=nothing, printed=score(1.0), still=nothing)
    assert lost.growth > ALLOWED
    assert not lost.holds
