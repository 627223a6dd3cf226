"""A CSV file whose logger was killed within its last line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from morph.record.read.csv import read_csv


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('t,a\n"3\n",2\n\n"3\n"\n', 6),
        ("t,a\n3,2\n3", 3),
        ("t,a\n3,2\n3\n", 3),
        ('t,a\n3,2\n"3,4\n', 3),
    ],
)
def test_a_torn_last_line_is_left_out_and_told(tmp_path: Path, text: str, line: int) -> None:
    path = tmp_path / "run.csv"
    path.write_text(text)
    table = read_csv(path)
    for column, value in zip(table.columns, (3.0, 2.0), strict=True):
        assert np.array_equal(np.asarray(column), [value])
    (note,) = table.notes
    assert note.what.startswith("the last line has 1 of 2 fields and was left out")
    assert note.where == f"{path}, line {line}"
    assert note.dropped == 1
