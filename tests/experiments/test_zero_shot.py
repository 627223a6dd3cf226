"""Tests of the study of the cart-pole's policy on many bodies."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.morphologies.summary import first_enough, gain_of, in_words
from experiments.zero_shot import main


def test_the_time_to_threshold_is_from_where_the_curve_stays_above_it() -> None:
    curve = {"10": 0.97, "20": 0.4, "30": 0.96, "60": 0.99}
    assert first_enough(curve, 1.0) == 30.0
    assert first_enough({"10": 0.97, "20": 0.4}, 1.0) == float("inf")


def test_a_quick_study_writes_its_figures_and_goes_on_from_what_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, cells = tmp_path / "out.json", tmp_path / "cells"
    told = ["--quick", "--seeds", "150:151", "--bodies", "rider_rigid_driven", "--workers", "1"]
    told += ["--json", str(out), "--out", str(cells)]
    assert main(told) == 0
    first = json.loads(out.read_text(encoding="utf-8"))
    zero = first["summary"]["zero_shot"]
    assert zero["map_only"]["iqm"] > 0.9
    assert zero["flipped_map_only"]["iqm"] < 0.5
    assert "noise 0: 60 transitions, 1 seeds" in capsys.readouterr().out
    assert main([*told, "--resume"]) == 0
    assert json.loads(out.read_text(encoding="utf-8")) == first


def test_what_a_wrong_map_does_as_well_is_no_gain_of_the_source() -> None:
    def way(solved: int) -> dict[str, object]:
        return {"solved": solved, "iqm": solved / 3.0, "bodies": {"a": 1, "b": 1, "c": 1}}

    solved = {"hop": 3, "shuffled": 3, "flipped": 1, "least_squares": 0, "ridge": 2}
    solved |= {"structured": 1, "structured_cautious": 1}
    zero = {name: way(count) for name, count in solved.items()}
    assert gain_of(zero) == 0
    said = in_words({"seeds": [0, 1], "zero_shot": zero})
    assert "hop 3 of 3 (1.00), over a shuffled map 3 of 3" in said
    assert "without a source (ridge) 2 of 3" in said
    zero["shuffled"] = way(0)
    assert gain_of(zero) == 1
