"""The command: cases generated, answers of another tool scored, and the baselines."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.concealed.__main__ import main
from experiments.concealed.generate import CASES, generate
from experiments.concealed.solvers import solve_by_chance, solve_by_oracle, solve_by_trust
from experiments.concealed.submission import check

SEED = 5
"""Of a clean suite whose first case is a pendulum."""


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the value of --out beside which one short clean case lies."""
    out = tmp_path_factory.mktemp("benchmark") / "study"
    generate("clean", SEED, [0], Path(f"{out}_cases") / "clean", seconds=2.0)
    return out


def test_answers_of_another_tool_are_scored(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = Path(f"{out}_cases") / "clean" / CASES / f"clean_{SEED}_0000"
    asked = ["--suite", "clean", "--seed", str(SEED), "--cases", "1", "--out", str(out), "--json"]
    asked += ["--submissions", str(tmp_path)]
    answers = {}
    for solve in (solve_by_oracle, solve_by_trust, solve_by_chance):
        answer = check(solve(case, 1), where=case.name)
        assert solve(case, 1) == answer
        (tmp_path / f"{case.name}.json").write_text(json.dumps(answer))
        assert main(asked) == 0
        answers[answer["solver"]] = json.loads(capsys.readouterr().out)["figures"]["submitted"]
    assert answers["oracle"]["clean_accused"]["value"] == 0.0
    assert answers["none"]["brier"]["value"] == 0.0
    assert answers["random"]["clean_accused"]["value"] in (0.0, 1.0)


def test_a_missing_answer_is_named(
    out: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["--suite", "clean", "--seed", str(SEED), "--cases", "1", "--out", str(out)]
    assert main([*asked, "--submissions", str(tmp_path)]) == 2
    assert f"clean_{SEED}_0000.json: cannot read" in capsys.readouterr().err
