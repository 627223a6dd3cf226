"""Tests of the study of the cart-pole's policy on many bodies."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.zero_shot import first_enough, main


def test_the_time_to_threshold_is_from_where_the_curve_stays_above_it() -> None:
    curve = {"10": 0.97, "20": 0.4, "30": 0.96, "60": 0.99}
    assert first_enough(curve, 1.0) == 30.0
    assert first_enough({"10": 0.97, "20": 0.4}, 1.0) == float("inf")


def test_a_quick_study_writes_its_figures_and_goes_on_from_what_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, kept = tmp_path / "out.json", tmp_path / "kept.jsonl"
    told = ["--quick", "--seeds", "150:151", "--bodies", "rider_rigid_driven", "--workers", "1"]
    told += ["--json", str(out), "--kept", str(kept)]
    assert main(told) == 0
    first = json.loads(out.read_text(encoding="utf-8"))
    zero = first["summary"]["zero_shot"]
    assert zero["map_only"]["iqm"] > 0.9
    assert zero["flipped_map_only"]["iqm"] < 0.5
    assert main(told) == 0
    assert json.loads(out.read_text(encoding="utf-8")) == first
    assert len(kept.read_text(encoding="utf-8").splitlines()) == 1
    assert "1/1 rider_rigid_driven 150" in capsys.readouterr().err
