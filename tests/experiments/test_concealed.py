"""The study of concealed cases, in small: what it finds and how it judges."""

from __future__ import annotations

from pathlib import Path

from experiments.conceal import generate, make_cases
from experiments.concealed import diagnosed, judged


def _case(tmp_path: Path, seed: int, *, clean: bool) -> Path:
    cases = make_cases(1, seed, clean=clean)
    generate(cases, tmp_path)
    return tmp_path / cases[0].name


def test_a_concealed_effect_is_named_at_its_place(tmp_path: Path) -> None:
    case = _case(tmp_path, 4, clean=False)
    row = judged(diagnosed(case), case)
    assert (row["truth"], row["at"]) == ("coulomb_friction", "hinge")
    assert (row["named"], row["named_at"]) == ("coulomb_friction", "hinge")
    assert row["verdict"] == "mismatch"


def test_wrong_masses_alone_are_no_finding_and_the_seal_is_never_opened(tmp_path: Path) -> None:
    # Without the seal in the case's folder the diagnosis must work all the same.
    case = _case(tmp_path, 2, clean=True)
    (case / "sealed").rename(tmp_path / "sealed")
    answer = diagnosed(case)
    (tmp_path / "sealed").rename(case / "sealed")
    row = judged(answer, case)
    assert (row["truth"], row["named"], row["verdict"]) == ("none", "none", "consistent")
