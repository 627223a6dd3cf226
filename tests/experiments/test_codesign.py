"""The study of body and policy, small."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments import codesign
from experiments.codesign import Case, main, measured


def test_each_way_tells_how_far_it_came_and_with_which_legs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(codesign, "HORIZON", 0.4)
    monkeypatch.setattr(codesign, "ROWS", 1)
    row = measured(Case(seed=100, way="gait alone", generations=1))
    assert row["legs"] == pytest.approx({"front": 1.0, "rear": 1.0})
    # In 0.4 s, at less than 1 m/s.
    assert abs(row["far"]) < 0.4


def test_the_study_writes_the_interquartile_mean_of_each_way(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def told(case: Case) -> dict[str, object]:
        legs = {"front": 1.0, "rear": 1.0}
        return {"way": case.way, "seed": case.seed, "far": 0.1 * case.seed, "legs": legs}

    monkeypatch.setattr(codesign, "measured", told)
    kept = tmp_path / "found.json"
    main(["--seeds", "1:5", "--only", "together", "--workers", "1", "--json", str(kept)])
    # Of 0.1, 0.2, 0.3 and 0.4 the middle half is 0.2 and 0.3.
    assert json.loads(kept.read_text())["ways"]["together"]["iqm"] == pytest.approx(0.25)
