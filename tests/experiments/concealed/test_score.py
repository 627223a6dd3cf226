"""The scorer against answers whose score is plain."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from experiments.concealed.errors import BenchmarkError
from experiments.concealed.score import score
from experiments.concealed.seal import Sealed
from experiments.concealed.submission import check, load_submission, submission
from experiments.concealed.summary import calibration_error, summarise

PARTS = {
    "world": -1,
    **dict.fromkeys(("hip", "thigh", "hip_drive", "hip.position"), 0),
    **dict.fromkeys(("knee", "shank", "knee_drive", "knee.position"), 1),
}


def effect(name: str, where: str, **figures: float) -> dict[str, Any]:
    return {
        "effect": name, "where": {"kind": "joint", "name": where}, "figures": figures,
        "scored": list(figures), "effect_to_noise": 5.0, "after_refit": 2.5,
        "run": None, "anywhere": False, "ties": [], "why": "",
    }  # fmt: skip


def sealed(*effects: dict[str, Any], answer: str = "effects") -> Sealed:
    about = {
        "case": "judge_1_0000", "family": "leg", "answer": answer, "effects": list(effects),
        "parts": PARTS, "reading_error": [0.1, 0.1], "nominal_error": 11.0, "oracle_error": 1.0,
    }  # fmt: skip
    return Sealed(about=about, held_out=np.zeros((4, 2)), oracle=np.zeros((4, 2)))


def said(*named: tuple[str, str, float], **more: Any) -> dict[str, Any]:
    findings = [{"effect": e, "where": w, "probability": p} for e, w, p in named]
    return check(submission("judge_1_0000", "test", findings=findings, **more), where="test")


DRY, WET = effect("coulomb_friction", "hip", c=0.2), effect("viscous_friction", "knee", b=0.1)


def test_two_right_findings_in_any_order_are_the_exact_set() -> None:
    answer = said(("viscous_friction", "knee", 0.9), ("coulomb_friction", "hip", 0.8))
    row = score(answer, sealed(DRY, WET))
    assert (row["exact"], row["first"], row["place"], row["extra"]) == (True, True, True, 0)
    assert row["claims"][:2] == [(0.9, True), (0.8, True)]


@pytest.mark.parametrize(
    ("named", "first", "place", "extra"),
    [
        (("coulomb_friction", "knee", 0.9), True, False, 1),
        (("cogging", "hip", 0.9), False, True, 1),
        (("cogging", "thigh", 0.9), False, True, 1),
        (("cogging", "elsewhere", 0.9), False, False, 1),
    ],
)
def test_name_and_place_are_scored_apart(
    named: tuple[str, str, float], first: bool, place: bool, extra: int
) -> None:
    row = score(said(named), sealed(DRY))
    found = (row["first"], row["place"], row["extra"], row["exact"])
    assert found == (first, place, extra, False)


def test_one_finding_named_twice_is_one_too_many() -> None:
    row = score(said(*[("coulomb_friction", "hip", 0.9)] * 2), sealed(DRY))
    assert (row["extra"], row["exact"]) == (1, False)


def test_a_rival_counts_among_the_first_three_and_the_fourth_does_not() -> None:
    rivals = [{"effect": "cogging", "where": "hip", "probability": 0.1}] * 2
    right = {"effect": "coulomb_friction", "where": "hip", "probability": 0.1}
    wrong = ("backlash", "hip", 0.5)
    assert score(said(wrong, rivals=[rivals[0], right]), sealed(DRY))["first_three"]
    assert not score(said(wrong, rivals=[*rivals, right]), sealed(DRY))["first_three"]


def test_a_tie_is_as_right_as_the_truth_at_its_own_place() -> None:
    tied = {**WET, "ties": [{"effect": "back_emf", "where": "knee_drive", "reason": "powered"}]}
    row = score(said(("back_emf", "knee_drive", 0.9)), sealed(tied))
    assert (row["exact"], row["first"], row["place"]) == (True, True, True)
    assert not score(said(("back_emf", "hip_drive", 0.9)), sealed(tied))["exact"]


def test_what_acts_everywhere_may_be_named_anywhere() -> None:
    sag = {**effect("voltage_sag", "hip_drive", k=0.1), "anywhere": True}
    assert score(said(("voltage_sag", "knee_drive", 0.9)), sealed(sag))["exact"]


@pytest.mark.parametrize(("low", "high", "held"), [(0.1, 0.3, True), (0.21, 0.3, False)])
def test_intervals_are_of_right_findings_alone(low: float, high: float, held: bool) -> None:
    answer = said(("coulomb_friction", "hip", 0.9), ("viscous_friction", "hip", 0.9))
    for finding in answer["findings"]:
        stated = {"value": 0.2, "low90": low, "high90": high}
        finding["parameters"] = {"c": stated, "b": stated}
    assert score(answer, sealed(DRY))["intervals"] == [held]


@pytest.mark.parametrize(("offset", "share"), [(0.1, 1.0), (1.1, 0.0), (2.1, -1.0), (0.6, 0.5)])
def test_the_share_of_the_oracle_s_improvement(offset: float, share: float) -> None:
    # Readings off by 0.1, 0.6, 1.1 and 2.1 are 1, 6, 11 and 21 errors; (11 - e) / (11 - 1).
    columns = {name: [offset] * 4 for name in ("hip.position", "knee.position")}
    row = score(said(none=1.0, predicted=columns), sealed(DRY))
    assert row["E"] == pytest.approx(share)


def test_predictions_of_another_length_are_refused() -> None:
    columns = {name: [0.0] * 3 for name in ("hip.position", "knee.position")}
    with pytest.raises(BenchmarkError, match="predictions do not fit"):
        score(said(predicted=columns), sealed(DRY))


def test_clean_and_unknown_cases_are_counted_apart() -> None:
    clean, odd = sealed(answer="none"), sealed(effect("loose_mass", "thigh"), answer="unknown")
    rows = [
        score(said(none=1.0), clean), score(said(("cogging", "hip", 0.7)), clean),
        score(said(unknown=0.9), odd), score(said(unknown=0.4), odd), score(said(unknown=0.6), odd),
        score(said(unknown=0.6), clean),
    ]  # fmt: skip
    figures = summarise(rows)
    assert figures["clean_accused"]["value"] == pytest.approx(2 / 3)
    assert figures["unknown_right"]["value"] == pytest.approx(2 / 3)
    assert figures["unknown_wrong"]["value"] == pytest.approx(1 / 3)
    assert figures["first"] is None


def test_friction_loads_and_gains_of_arms_are_counted_apart() -> None:
    load = effect("payload", "shank", m=2.0)

    def carried(m: float, *others: tuple[str, str, float]) -> dict[str, Any]:
        answer = said(("payload", "shank", 0.9), *others)
        answer["findings"][0]["parameters"] = {"m": {"value": m}}
        return answer

    arm = sealed(DRY, effect("stribeck_friction", "knee", c=0.1), load)
    friction, gain = ("hysteresis", "hip", 0.8), ("torque_scale", "hip_drive", 0.7)
    rows = [
        score(carried(2.1, friction, gain), arm), score(carried(2.3), arm),
        score(said(("payload", "thigh", 0.9)), arm),
        score(said(gain), sealed(effect("torque_scale", "hip_drive", gain=0.8))),
    ]  # fmt: skip
    assert [row["load"] for row in rows] == [pytest.approx(0.05), pytest.approx(0.15), None, None]
    figures = summarise(rows)
    # Of six joints with friction one is named, of three loads one within a tenth, and of four
    # cases one has a gain that is right.
    found = [figures[name]["value"] for name in ("friction_named", "load_found", "gain_accused")]
    assert found == pytest.approx([1 / 6, 1 / 3, 1 / 4])


def test_pushes_are_found_by_run_and_start_and_changes_by_run_and_time() -> None:
    push = {**effect("external_push", "thigh", start=2.0, end=2.2), "run": 1}
    dry = {**DRY, "since": {"run": "run_3", "time": 4.0}}

    def finding(run: str, start: float) -> dict[str, Any]:
        named = {"effect": "external_push", "where": "thigh", "probability": 0.7}
        return {**named, "run": run, "parameters": {"start": {"value": start}}}

    def change(run: str, time: float, law: str = "coulomb_friction") -> dict[str, Any]:
        return {"effect": law, "where": "hip", "run": run, "time": time}

    def row(*findings: Any, changes: Any = (), truth: Any = (push,)) -> dict[str, Any]:
        answer = submission("judge_1_0000", "test", findings=findings, changes=changes)
        return score(check(answer, where="test"), sealed(*truth))

    # The truth counts runs from nought, recordings are called by their number from one.
    right = row(finding("run_2", 2.1))
    late, elsewhere = row(finding("run_2", 2.4)), row(finding("run_1", 2.0))
    assert [each["pushes_found"] for each in (right, late, elsewhere)] == [1, 0, 0]
    assert right["push_late"] == pytest.approx(0.1)
    assert elsewhere["push_late"] is None
    began = row(changes=[change("run_3", 4.2)], truth=(dry,))
    wrong = row(changes=[change("run_3", 4.2, "cogging")], truth=(dry,))
    off = row(changes=[change("run_3", 4.3)], truth=(dry,))
    assert [each["change_found"] for each in (began, wrong, off)] == [True, True, False]
    assert [each["change_named"] for each in (began, wrong, off)] == [True, False, False]
    found = summarise(
        [right, late, elsewhere, began, wrong, off, row(), row(changes=[change("a", 0)])]
    )
    # One of five pushes; one of three that were claimed; two and one of three changes; and one of
    # the five cases without a change was said to change.
    values = {name: found[name]["value"] for name in found if name.startswith(("push", "change"))}
    assert values == {
        "push_recall": pytest.approx(1 / 5),
        "push_precision": pytest.approx(1 / 3),
        "push_late_s": pytest.approx(0.25),
        "change_found": pytest.approx(2 / 3),
        "change_named": pytest.approx(1 / 3),
        "change_claimed_wrongly": pytest.approx(1 / 5),
    }


def test_calibration_error_and_brier_score_are_as_by_hand() -> None:
    # Bin of .9: three of four right, gap .15 of 4; bin of .2: none of two, gap .2 of 2.
    claims = [(0.9, True)] * 3 + [(0.9, False)] + [(0.2, False)] * 2
    assert calibration_error(claims) == pytest.approx((4 * 0.15 + 2 * 0.2) / 6)


def test_the_bootstrap_of_a_share_is_about_as_wide_as_the_binomial() -> None:
    right, wrong = score(said(("coulomb_friction", "hip", 1.0)), sealed(DRY)), score(
        said(none=1.0), sealed(DRY)
    )  # fmt: skip
    first = summarise([right, wrong] * 50)["first"]
    # sqrt(.5 * .5 / 100) * 1.645 = 0.082 on either side.
    assert first["value"] == 0.5
    assert first["high90"] - first["low90"] == pytest.approx(0.164, abs=0.03)


def test_a_submission_that_breaks_the_schema_is_refused_by_its_place(tmp_path: Path) -> None:
    answer = submission("judge_1_0000", "test", none=0.5)
    path = tmp_path / "answer.json"
    path.write_text(json.dumps({**answer, "none": 1.5}))
    with pytest.raises(BenchmarkError, match=r"\$\.none"):
        load_submission(path)
    path.write_text("{")
    with pytest.raises(BenchmarkError, match="cannot read"):
        load_submission(path)


def test_effects_that_own_figures_hide_count_apart() -> None:
    right = score(said(("coulomb_friction", "hip", 0.9)), sealed(DRY))
    hidden = score(said(), sealed({**DRY, "after_refit": 0.5}))
    figures = summarise([right, hidden])
    assert figures["first"]["value"] == 0.5
    assert figures["first_shown"]["value"] == figures["exact_set_shown"]["value"] == 1.0
