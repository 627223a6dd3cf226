"""The study of iterations, small."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments import iterated, iterations
from experiments.iterated import Case, measured
from experiments.iterations import main, summary


def test_one_case_is_measured_with_its_controls(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(iterated, "ROWS", 4)
    case = measured(Case(body="cartpole", seed=100, changes=1, anew=(6,), trials=0))
    (row,) = case["rows"]
    # Every law meets the same starts: what is carried is as good as the truth on the first body.
    assert row["scores"]["carried"] > 0.95 * row["scores"]["oracle"] > 0.9
    assert max(row["scores"][name] for name in ("still", "flipped", "shuffled")) < 0.5
    found = summary([case])
    assert found["enough"]["carried"]["solved"] == 1.0


def test_a_study_goes_on_from_what_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    row = {"scores": {"oracle": 1.0, "carried": 0.5}, "enough": {"carried": 6.0}}
    calls: list[Case] = []

    def counted(case: Case) -> dict[str, object]:
        calls.append(case)
        return {"body": case.body, "seed": case.seed, "rows": [row]}

    monkeypatch.setattr(iterations, "measured", counted)
    words = ["--seeds", "100:102", "--only", "cartpole", "--workers", "1"]
    words += ["--kept", str(tmp_path / "kept.jsonl"), "--json", str(tmp_path / "found.json")]
    main(words)
    main(words)
    assert [case.seed for case in calls] == [100, 101]
    found = json.loads((tmp_path / "found.json").read_text())
    assert found["scores"]["carried"]["iqm"] == 0.5
    assert "carried" in capsys.readouterr().out
