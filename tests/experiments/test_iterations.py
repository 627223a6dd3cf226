"""The study of iterations, small."""

from __future__ import annotations

import pytest

from experiments import iterated, iterations
from experiments.iterated import Case, measured
from experiments.iterations import summary


def test_one_case_is_measured_with_its_controls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(iterated, "ROWS", 4)
    case = measured(Case(body="cartpole", seed=100, changes=1, anew=(6,), trials=0))
    (row,) = case["rows"]
    # Every law meets the same starts: what is carried is as good as the truth on the first body.
    assert row["scores"]["carried"] > 0.95 * row["scores"]["oracle"] > 0.9
    assert max(row["scores"][name] for name in ("still", "flipped", "shuffled")) < 0.5
    found = summary([case])
    assert found["enough"]["carried"]["solved"] == 1.0


def test_a_way_that_needed_six_transitions_is_told_so() -> None:
    row = {"scores": {"oracle": 1.0, "carried": 0.5}, "enough": {"carried": 6.0}}
    cases = [{"body": "cartpole", "seed": seed, "rows": [row]} for seed in (100, 101)]
    found = iterations.summary(cases)
    assert found["scores"]["carried"]["iqm"] == 0.5
    assert found["enough"]["carried"] == {"solved": 1.0, "iqm": 6.0, "iterations": 2}
