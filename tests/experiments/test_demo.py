"""The demonstration on short runs: made once, diagnosed once, opened last."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from experiments import demo
from experiments.concealed.case import draw_case


def test_a_case_is_made_and_diagnosed_once_and_opened_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(demo, "draw_case", partial(draw_case, seconds=2.0))
    asked = ["--out", str(tmp_path)]
    assert demo.main(asked) == 0
    first = capsys.readouterr().out
    assert "2. Diagnosed in" in first
    assert "<html" in (tmp_path / "mismatch.html").read_text()[:1000]
    said = "error on held-out runs"
    assert first.index(said) < first.index("only now: double_pendulum: back_emf at actuator")
    assert demo.main(asked) == 0
    again = capsys.readouterr().out
    assert "nothing has changed since" in again
    assert again.partition(said)[2] == first.partition(said)[2]
    (case,) = tmp_path.glob("case/cases/*/case.json")
    case.write_text('{"vary": 3}')
    assert demo.main(asked) == 2
    assert capsys.readouterr().err.startswith(f"error: {case}: the case cannot be read")


def test_a_negative_seed_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        demo.main(["--seed", "-1"])
    assert "--seed must not be negative" in capsys.readouterr().err
