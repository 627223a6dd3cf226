"""The studies of harm and of similarity on one target."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments import harm, similarity
from experiments.figures.result_file import load_result


def test_harm_is_told_of_every_policy_of_a_target(tmp_path: Path) -> None:
    asked = ["--quick", "--engine", "inline", "--json", str(tmp_path / "a.json")]
    asked += ["--out", str(tmp_path / "cells")]
    assert harm.main([*asked, "--save-as", str(tmp_path / "saved.json")]) == 0
    found = json.loads((tmp_path / "a.json").read_text())
    assert found["targets"] == 1
    assert 8 <= found["pairs"] <= 15
    assert sum(each["pairs"] for each in found["calibration"]) == found["pairs"]
    saved = load_result(tmp_path / "saved.json")
    assert saved["figures"]["guard_area"] == pytest.approx(found["figures"]["guard"]["area"])
    assert "always accept" in saved["controls"]


def test_six_sources_of_a_target_are_compared(tmp_path: Path) -> None:
    out = ["--out", str(tmp_path / "cells"), "--json", str(tmp_path / "b.json")]
    assert similarity.main(["--quick", "--engine", "inline", *out]) == 0
    found = json.loads((tmp_path / "b.json").read_text())
    assert found["pairs"] == 6
    assert set(found["figures"]) == set(similarity.METRICS)
