"""From bets and probabilities to an answer, on evidence that is known exactly."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from morph.model.kwik.certify import _answer, believed, verdict_of
from morph.model.kwik.e_values import bets
from morph.model.kwik.innovations import Account
from morph.model.kwik.transition_evidence import Visit

SURE = math.log(20.0)
"""What a bet must have won where verdicts may be wrong once in twenty times."""


@pytest.mark.parametrize(
    ("probability", "for_good", "for_bad", "answer"),
    [
        (0.96, SURE + 0.1, -1.0, "good"),
        (0.04, -1.0, SURE + 0.1, "not good"),
        # A bet alone, or a probability alone, settles nothing; nor does either the wrong way.
        (0.94, SURE + 0.1, -1.0, "cannot say"),
        (0.96, SURE - 0.1, -1.0, "cannot say"),
        (0.06, -1.0, SURE + 0.1, "cannot say"),
        (0.04, -1.0, SURE - 0.1, "cannot say"),
        (0.96, -1.0, SURE + 0.1, "cannot say"),
        (0.5, -1.0, -1.0, "cannot say"),
    ],
)
def test_an_answer_needs_a_won_bet_and_a_probability_that_agrees(
    probability: float, for_good: float, for_bad: float, answer: str
) -> None:
    assert _answer(probability, for_good, for_bad, 0.05) == answer


def errs_at(beyond: int, transitions: int = 40) -> Visit:
    """Return what was visited of a target whose one figure is 0.3, known to a thousandth.

    The model errs by two epsilons at so many transitions and by a tenth at the others.
    """
    slope = np.zeros((transitions, 1, 3))
    slope[:, :, 0] = 1000.0
    error = np.zeros((transitions, 1, 3))
    error[:, :, 0] = 0.1 / 0.3
    error[:beyond, :, 0] = 2.0 / 0.3
    return Visit(
        account=Account(surprise=np.full((transitions, 1), 300.0), slope=slope),
        about=np.zeros(3),
        error=error,
        named=1,
        unnamed=cast(Any, SimpleNamespace(smooth=1)),
    )


@pytest.mark.parametrize(("beyond", "answer"), [(0, "good"), (4, "good"), (5, "not good")])
def test_a_tenth_of_the_transitions_may_err_and_no_more(beyond: int, answer: str) -> None:
    hypothesis = SimpleNamespace(
        start=np.zeros(1), knobs=("weight",), low=np.array([-1.0]), high=np.array([1.0])
    )
    found = verdict_of(
        errs_at(beyond),
        40,
        cast(Any, hypothesis),
        np.ones(1),
        0.05,
        0.1,
        np.random.default_rng(0),
    )
    # A tenth of forty is four.
    assert found.verdict == answer
    assert found.probability == (1.0 if answer == "good" else 0.0)
    assert found.transitions.tolist() == [0.0] * beyond + [1.0] * (40 - beyond)
    assert found.error[:, 0] == pytest.approx([2.0] * beyond + [0.1] * (40 - beyond), abs=0.01)


@pytest.mark.parametrize(("scatter", "times"), [(0.0, 1.0), (0.5, 1.0), (10.0, 10.0)])
def test_doubt_grows_where_nothing_fits_and_nowhere_else(scatter: float, times: float) -> None:
    seen = errs_at(0)
    seen.account.surprise[:] += scatter * np.where(np.arange(40) % 2, 1.0, -1.0)[:, None]
    held = believed(seen.until(40), seen, 40, np.ones(1))
    drawn = held.draws(4000, np.random.default_rng(0))[:, 0]
    # Forty readings of slope 1000 and a deviation of 1 tell a figure to 1 / (1000 sqrt(40)); where
    # they scatter ten times as much, to ten times that. 4000 draws tell it to 4 / sqrt(8000).
    assert drawn.std() == pytest.approx(times / (1000.0 * np.sqrt(40.0)), rel=0.05)
    assert drawn.mean() == pytest.approx(0.3, abs=1e-3)


def test_bets_win_half_the_square_of_the_distance_to_what_they_are_against() -> None:
    sd = 1.0 / (1000.0 * np.sqrt(40.0))

    def told(beyond: int) -> tuple[float, float]:
        seen = errs_at(beyond)
        held = believed(seen.until(40), seen, 40, np.ones(1))
        return bets(held, np.ones(1), seen.error, 5)

    # Against "not good": five errors of 0.1 that would have to be 1, a slope of 0.1 / 0.3 each.
    assert told(0)[0] == pytest.approx(0.5 * (0.9 / (sd * 0.1 / 0.3)) ** 2, rel=0.01)
    # Against "good": five errors of 2 that would have to be 1, a slope of 2 / 0.3 each.
    assert told(5)[1] == pytest.approx(0.5 * (1.0 / (sd * 2.0 / 0.3)) ** 2, rel=0.01)


def test_evidence_is_the_same_wherever_it_was_linearised() -> None:
    here = errs_at(0)
    # From 0.1 on, 0.2 are left of a figure of 0.3.
    moved = replace(
        here,
        account=replace(here.account, surprise=np.full((40, 1), 200.0)),
        about=np.array([0.1, 0.0, 0.0]),
    )
    for ours, theirs in zip(
        vars(here.until(7)).values(), vars(moved.until(7)).values(), strict=True
    ):
        assert theirs == pytest.approx(ours)
