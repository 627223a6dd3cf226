"""The page on maps: its example runs, and its table names the family."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from morph.alignment.maps.maps import MAPPERS

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "maps.md").read_text(encoding="utf-8")


def test_the_table_has_every_map() -> None:
    rows = re.findall(r"^\| `(\w+)` \|", TEXT, re.MULTILINE)
    assert rows == [each.name for each in MAPPERS]


def test_the_example_finds_what_undoes_the_disguise(capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
    exec(compile(code, "docs/maps.md", "exec"), {})
    first, second, figures = capsys.readouterr().out.splitlines()
    law = [[float(n) for n in re.findall(r"-?\d+\.?\d*", row)] for row in (first, second)]
    # y = (2 v, -q / 2): q = -2 y_2 and v = y_1 / 2, or both with the other sign.
    sign = 1.0 if law[1][0] > 0.0 else -1.0
    assert sign * law[0][1] == pytest.approx(-2.0, abs=0.05)
    assert sign * law[1][0] == pytest.approx(0.5, abs=0.02)
    round_trip, missed = (float(number) for number in figures.split())
    assert round_trip < 1e-4
    assert missed < 0.01
