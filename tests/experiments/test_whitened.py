"""The ranking by whitened columns, on one concealed case."""

from __future__ import annotations

import json

import pytest

from experiments import whitened


def test_a_concealed_effect_stands_first(capsys: pytest.CaptureFixture[str]) -> None:
    assert whitened.main(["--seed", "906", "--cases", "1"]) == 0
    row, shares = map(json.loads, capsys.readouterr().out.splitlines())
    assert row["rank"] == 1
    assert next(iter(row["first"])) == row["truth"]
    assert shares == {"first": 1.0, "in_the_first_three": 1.0, "cases": 1}
