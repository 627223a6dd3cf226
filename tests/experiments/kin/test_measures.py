"""Figures of both studies on tables whose figures are known."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.kin.measures import accepted, area, calibration, chosen_well, within


def test_the_area_is_how_often_the_harmful_one_of_two_is_the_more_suspect() -> None:
    # Of the four pairs (0.9, 0.1), (0.9, 0.5), (0.5, 0.1), (0.5, 0.5): three right, one tie.
    harmful = np.array([True, True, False, False])
    suspicion = np.array([0.9, 0.5, 0.1, 0.5])
    assert area(harmful, suspicion) == pytest.approx(3.5 / 4.0)


def test_useful_pairs_are_accepted_below_the_harmful_that_may_not_be() -> None:
    # Of 100 harmful pairs at 0.50 .. 0.995 two may be accepted: the bound is the third, 0.51.
    harmful = np.array([True] * 100 + [False] * 4)
    suspicion = np.array([*(0.5 + 0.005 * np.arange(100)), 0.1, 0.505, 0.51, 0.9])
    assert accepted(harmful, ~harmful, suspicion) == 0.5


def test_who_accepts_always_accepts_no_useful_pair_at_two_in_a_hundred() -> None:
    harmful = np.array([True, False, False])
    assert accepted(harmful, ~harmful, np.zeros(3)) == 0.0


def test_an_interval_of_equal_targets_is_a_point() -> None:
    groups = ["a", "a", "b", "b"]
    x = np.array([1.0, 3.0, 1.0, 3.0])
    assert within(groups, lambda rows: float(x[rows].mean())) == (2.0, 2.0)


def test_calibration_counts_each_pair_once() -> None:
    harmful, probability = np.array([False, True, True]), np.array([0.0, 0.5, 1.0])
    lines = calibration(harmful, probability, (0.0, 0.5, 1.01))
    assert [line["pairs"] for line in lines] == [1, 2]
    assert [line["harmful"] for line in lines] == [0.0, 1.0]


def test_a_source_is_chosen_well_if_it_is_within_noise_of_the_best() -> None:
    targets = ["a", "a", "b", "b"]
    promise = np.array([1.0, 0.0, 1.0, 0.0])
    # The chosen of a is 0.01 below the best, the chosen of b 0.5.
    jumpstart = np.array([0.80, 0.81, 0.3, 0.8])
    assert chosen_well(targets, promise, jumpstart).tolist() == [1.0, 0.0]


def test_an_interval_is_of_targets_drawn_and_not_of_their_pairs() -> None:
    value = np.repeat([0.0, 1.0], 50)
    # Of four draws of two targets one is the first alone, and one the second alone.
    found = within(["a"] * 50 + ["b"] * 50, lambda rows: float(value[rows].mean()))
    assert found == (0.0, 1.0)
