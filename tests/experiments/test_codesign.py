"""The study of body and policy, small."""

from __future__ import annotations

import pytest

from experiments import codesign
from experiments.codesign import Case, main, measured, summary


def test_each_way_tells_how_far_it_came_and_with_which_legs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(codesign, "HORIZON", 0.4)
    monkeypatch.setattr(codesign, "ROWS", 1)
    row = measured(Case(seed=100, way="gait alone", generations=1))
    assert row["legs"] == pytest.approx({"front": 1.0, "rear": 1.0})
    # In 0.4 s, at less than 1 m/s.
    assert abs(row["far"]) < 0.4


def test_a_way_is_told_by_its_interquartile_mean() -> None:
    legs = {"front": 1.0, "rear": 1.0}
    rows = [{"way": "together", "far": 0.1 * seed, "legs": legs} for seed in range(1, 5)]
    # Of 0.1, 0.2, 0.3 and 0.4 the middle half is 0.2 and 0.3.
    assert summary(rows)["together"]["iqm"] == pytest.approx(0.25)


def test_an_unknown_way_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["--only", "sideways"])
    assert "invalid choice: 'sideways'" in capsys.readouterr().err
