"""The study of concealed cases, in small: what it finds and how it judges."""

from __future__ import annotations

from pathlib import Path

from experiments.conceal import generate, make_cases
from experiments.concealed import diagnosed, headline, judged


def _case(tmp_path: Path, seed: int, *, clean: bool) -> Path:
    cases = make_cases(1, seed, clean=clean)
    generate(cases, tmp_path)
    return tmp_path / cases[0].name


def test_a_concealed_effect_is_named_at_its_place(tmp_path: Path) -> None:
    case = _case(tmp_path, 4, clean=False)
    answer = diagnosed(str(case))
    row = judged(answer, case)
    assert (row["truth"], row["at"]) == ("coulomb_friction", "hinge")
    assert (row["named"], row["named_at"]) == ("coulomb_friction", "hinge")
    assert row["verdict"] == "mismatch"
    # The rival always names something, and is judged by the same truth.
    said = answer["regression"]
    assert 0.0 < said["gain"] <= 1.0
    assert row["regression_right"] == (said["effect"] == "coulomb_friction")
    assert row["regression_place"] == (said["place"].removesuffix(".position") == "hinge")


def test_wrong_masses_alone_are_no_finding_and_the_seal_is_never_opened(tmp_path: Path) -> None:
    # Without the seal in the case's folder the diagnosis must work all the same.
    case = _case(tmp_path, 2, clean=True)
    (case / "sealed").rename(tmp_path / "sealed")
    answer = diagnosed(str(case))
    (tmp_path / "sealed").rename(case / "sealed")
    row = judged(answer, case)
    assert (row["truth"], row["named"], row["verdict"]) == ("none", "none", "consistent")


def test_the_rival_s_share_stands_beside_the_diagnosis_s() -> None:
    row = {"truth": "armature", "named": "armature", "right": True, "place": True, "rival": False}
    rows = [
        {**row, "regression_right": False, "regression_place": True},
        {**row, "regression_right": True, "regression_place": True},
    ]
    told = headline(rows)
    assert told["figures"]["named_percent"] == 100.0
    rival = told["controls"]["linear regression names the first"]
    assert rival == {"named_percent": 50.0, "place_percent": 100.0}


def test_the_regression_s_false_alarms_stand_beside_the_diagnosis_s() -> None:
    row = {"truth": "none", "named": "none", "right": True, "place": True, "rival": False}
    row |= {"regression_right": False, "regression_place": False}
    saved = headline([{**row, "regression_named": name} for name in ("armature", "none")])
    assert saved["figures"]["false_alarms"] == 0
    assert [list(each.values()) for each in saved["controls"].values()] == [[1]]
