from __future__ import annotations

import re
from pathlib import Path

import pytest

from experiments.rivals import WORLDS
from morph.policy_transfer.baselines.baselines import BASELINES

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "baselines.md").read_text(encoding="utf-8")


def test_the_table_has_every_rival_by_its_name_and_class() -> None:
    rows = re.findall(r"^\| ([\w ]+) \| `(\w+)` \|", TEXT, re.MULTILINE)
    assert rows == [(kind.name, kind.__name__) for kind in BASELINES]


def test_the_example_runs(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    # The first trial of five, in which nothing is learned yet, takes seconds less.
    exec(compile(code.replace("trials=5", "trials=1"), "docs/baselines.md", "exec"), {})
    (line,) = capsys.readouterr().out.splitlines()
    number, loss, success, *_ = line.split()
    # The target is the source: its policy works there, and hanging still would cost 61.
    assert (number, success) == ("1", "1.0")
    assert float(loss) < 30.0


def test_every_change_of_the_study_is_told() -> None:
    factors = sorted({factor for _, factor in WORLDS.values()} - {1.0})
    assert all(f"by {factor:g}" in re.sub(r"\s+", " ", TEXT) for factor in factors)
