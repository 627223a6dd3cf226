"""The study of the gate: its measures on figures known by hand, and its cases."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from experiments.gate import __main__ as study
from experiments.gate import report
from experiments.gate.asked import watched
from experiments.gate.controls import CONTROLS
from experiments.gate.measures import Judged, calibration, is_good, reliability, summary, wilson
from experiments.gate.targets import FAMILIES, Case, ahead, case, differing, drawn, nominal
from morph.policy.linear import Linear
from morph.policy.observing import observations_of
from morph.policy.policy import actions_of


@pytest.fixture(scope="module")
def pushing() -> Linear:
    robot = nominal().robot
    return Linear(
        action=actions_of(robot),
        observation=observations_of(robot),
        period=nominal().period,
        weight=np.array([[-2.0, 8.0, -1.0, 1.0]]),
        bias=np.array([3.0]),
    )


def answered(answers: str, truth: str, sure: tuple[float, ...]) -> Judged:
    """Return a case from letters: g(ood), b(ad) or ?."""
    said = {"g": "good", "b": "not good", "?": "cannot say"}
    return Judged(
        seed=0,
        family="small",
        label="m x1.01",
        moments=tuple(range(1, len(answers) + 1)),
        answers=tuple(said[letter] for letter in answers),
        sure=sure,
        truth=tuple(letter == "g" for letter in truth),
        inside=np.array([True, False]),
        transitions=np.array([0.9, 0.1]),
    )


def test_an_accept_is_false_if_the_model_is_bad_at_that_moment() -> None:
    cases = [
        answered("?gb", "ggb", (0.5, 0.99, 0.0)),
        answered("?g?", "gbb", (0.5, 0.99, 0.5)),
        answered("??g", "ggg", (0.5, 0.5, 0.99)),
    ]
    found = summary(cases, 0.05)
    # The first accepts while the model is still good; the second when it no longer is.
    assert (found["false_accepts"]["count"], found["false_accepts"]["of"]) == (1, 2)
    assert (found["false_rejects"]["count"], found["false_rejects"]["of"]) == (0, 3)
    assert (found["accepted"]["count"], found["accepted"]["of"]) == (1, 1)
    assert (found["rejected"]["count"], found["rejected"]["of"]) == (1, 2)
    assert found["by_probability"]["false_accepts"]["count"] == 1
    # The one good model is accepted; of two bad ones the first alone is rejected.
    assert (found["good_withheld"]["count"], found["good_withheld"]["of"]) == (0, 1)
    assert (found["bad_not_rejected"]["count"], found["bad_not_rejected"]["of"]) == (1, 2)


def test_a_gate_that_accepts_nothing_is_never_wrong_and_its_headline_says_the_price() -> None:
    cases = [answered("??", "gg", (0.5, 0.5))] * 3 + [answered("?b", "bb", (0.5, 0.0))]
    said = report.headline(summary(cases, 0.05))
    assert "wrongly accepted at the worst moment 0 of 1;" in said
    assert "good, and not accepted after one run 3 of 3;" in said
    assert "bad, and not rejected after one run 0 of 1" in said


def test_probabilities_that_come_true_as_often_as_said_are_calibrated() -> None:
    probability = np.repeat([0.25, 0.75], 100)
    truth = np.concatenate([np.arange(100) < 25, np.arange(100) < 75]).astype(float)
    assert calibration(probability, truth) == pytest.approx(0.0)
    # All said 0.25 too little: the error is 0.25.
    assert calibration(probability - 0.25, truth) == pytest.approx(0.25)
    assert [row["cases"] for row in reliability(probability, truth)] == [100, 100]


def test_an_interval_of_a_share_holds_what_tables_say() -> None:
    # Brown, Cai and DasGupta 2001: Wilson's interval for 0 of n is 0 to z^2 / (n + z^2).
    assert wilson(0, 20) == pytest.approx((0.0, 1.96**2 / (20 + 1.96**2)))


def test_a_model_is_good_if_it_errs_at_no_more_than_a_share_of_transitions() -> None:
    error = np.zeros((60, 2))
    error[:3, 1] = 1.0
    assert is_good(error, np.array([1.0, 1.0]), 0.05)
    error[3, 0] = -1.0
    assert not is_good(error, np.array([1.0, 1.0]), 0.05)


def test_the_same_seed_is_the_same_case(pushing: Linear) -> None:
    one, again = drawn(1200, [pushing]), drawn(1200, [pushing])
    assert (one.family, one.label) == (again.family, again.label)
    np.testing.assert_array_equal(one.run.position, again.run.position)


def test_every_family_can_be_drawn() -> None:
    for family in FAMILIES:
        for seed in range(20):
            factors, effects = differing(family, np.random.default_rng(seed))
            assert bool(factors or effects) == (family != "unchanged")


def made(pushing: Linear, factors: dict[str, float]) -> Case:
    rng = np.random.default_rng(1300)
    return case(1300, "ten", factors, (), [pushing], rng)


def test_the_model_errs_nowhere_on_itself_and_its_runs_are_noisy(pushing: Linear) -> None:
    same = made(pushing, {})
    # One step after the other, or 60 transitions in one batch: the same arithmetic.
    np.testing.assert_allclose(same.error, 0.0, atol=1e-12)
    # 244 readings with a deviation of 0.01: its estimate is within 5 x 0.01 / sqrt(488).
    assert np.std(same.run.state - same.state) == pytest.approx(0.01, abs=0.0023)


def test_the_true_error_is_the_difference_of_two_simulations(pushing: Linear) -> None:
    heavy = made(pushing, {"M": 1.1})
    there = ahead(heavy.task.simulator(), heavy.state[:-1], heavy.run.command, 0.05)
    np.testing.assert_allclose(there, heavy.state[1:], atol=1e-12)
    assert np.abs(heavy.error).max() > 0.02


def test_a_case_is_watched_to_its_end_and_every_control_answers(pushing: Linear) -> None:
    heavy = made(pushing, {"M": 1.1})
    gate = watched(heavy)
    assert gate.moments[-1] == 60
    for way in CONTROLS.values():
        said = way(heavy)
        assert said.truth == gate.truth[-1:]
        assert ((said.transitions >= 0.0) & (said.transitions <= 1.0)).all()


def test_the_study_reports_in_words_and_in_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["--quick", "--seed", "1300", "--json"]
    assert study.main([*asked, "--engine", "inline", "--out", str(tmp_path)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "morph.gate/1"
    assert found["gate"]["cases"] == 4
    report.told(found)
    assert "false accepts at the worst moment" in capsys.readouterr().out
    assert report.page(found).startswith("<!doctype html>")
