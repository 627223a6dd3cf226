"""The study of concealed cases, in small: what is sealed, what it finds and how it judges."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.conceal import generate, make_cases, open_seal
from experiments.conceal.laws import LAWS
from experiments.conceal.mechanisms import MECHANISMS
from experiments.conceal.seal import SealError
from experiments.concealed import diagnosed, headline, judged
from morph.body.load import load
from morph.record.load import load as load_recordings

(HIDDEN,) = make_cases(1, 4, clean=False)
(CLEAN,) = make_cases(1, 2, clean=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a case of an effect and a clean one, both of the pendulum, made together."""
    made = tmp_path_factory.mktemp("cases")
    generate([HIDDEN, CLEAN], made)
    return made


def test_the_seal_lies_outside_the_recordings(folder: Path) -> None:
    told = sorted(p.name for p in (folder / HIDDEN.name / "recordings").iterdir())
    assert told == [f"episode_{i}.csv.gz" for i in range(1, 6)] + ["recording.toml"]
    assert (folder / HIDDEN.name / "sealed" / "truth.sealed.json").is_file()


def test_the_recordings_are_what_morph_reads(folder: Path) -> None:
    episodes = load_recordings(folder / HIDDEN.name / "recordings", robot=load("pendulum"))
    assert [episode.session for episode in episodes] == ["first"] * 3 + ["second"] * 2
    for episode in episodes:
        assert set(episode.channels) == {"hinge.position", "hinge.command"}
        assert 7.9 < episode.seconds <= 8.0
        assert episode.channel("hinge.command").hold
        assert not episode.notes


def test_the_seal_opens_with_what_was_asked(folder: Path) -> None:
    sealed = open_seal(folder / HIDDEN.name)
    assert sealed.case == HIDDEN
    assert 3 <= sealed.strength <= 60
    ratios = [sealed.true[k] / sealed.nominal[k] for k in MECHANISMS[sealed.case.robot].varied]
    assert all(0.9 <= ratio <= 1.1 and ratio != 1 for ratio in ratios)


def test_a_clean_case_hides_nothing(folder: Path) -> None:
    sealed = open_seal(folder / CLEAN.name)
    assert (sealed.parameters, sealed.strength) == ({}, 0.0)


def test_a_missing_seal_is_named(tmp_path: Path) -> None:
    with pytest.raises(SealError, match=r"truth\.sealed\.json.*cannot open"):
        open_seal(tmp_path)


def test_every_law_is_hidden_equally_often() -> None:
    cases = make_cases(60, 1, clean=False)
    assert [sum(c.effect == law for c in cases) for law in LAWS] == [6] * 10
    assert cases == make_cases(60, 1, clean=False)
    assert all(c.effect is None and c.place is None for c in make_cases(5, 1, clean=True))


def test_a_concealed_effect_is_named_at_its_place(folder: Path) -> None:
    case = folder / HIDDEN.name
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


def test_wrong_masses_alone_are_no_finding_and_the_seal_is_never_opened(
    folder: Path, tmp_path: Path
) -> None:
    # Without the seal in the case's folder the diagnosis must work all the same.
    case = folder / CLEAN.name
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
