"""The studies of harm and of similarity on one target."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments import harm, similarity


def test_harm_is_told_of_every_policy_of_a_target_and_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["--quick", "--kept", str(tmp_path / "kept.jsonl"), "--json", str(tmp_path / "a.json")]
    assert harm.main(asked) == 0
    assert "1/1 body 199.0" in capsys.readouterr().err
    found = json.loads((tmp_path / "a.json").read_text())
    assert found["targets"] == 1
    assert 8 <= found["pairs"] <= 15
    assert sum(each["pairs"] for each in found["calibration"]) == found["pairs"]
    # Asked again it has nothing left to do.
    assert harm.main(asked) == 0
    assert capsys.readouterr().err == ""


def test_six_sources_of_a_target_are_compared(tmp_path: Path) -> None:
    assert similarity.main(["--quick", "--json", str(tmp_path / "b.json")]) == 0
    found = json.loads((tmp_path / "b.json").read_text())
    assert found["pairs"] == 6
    assert set(found["figures"]) == set(similarity.METRICS)
