from __future__ import annotations

import json
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from morph.errors import StudyError
from morph.study.cell import cells_of
from morph.study.compare import RowDifference, compare
from morph.study.engine import EngineOptions
from morph.study.run import run


@pytest.fixture
def two(toy: ModuleType, tmp_path: Path) -> tuple[Path, Path]:
    """Two runs of the same cells, the second with one cell less and one more."""
    for name, xs in (("first", range(4)), ("second", range(1, 5))):
        cells = cells_of(toy.spoiled, [{"x": x} for x in (*xs, 6, 7)])
        run(cells, folder=tmp_path / name, options=EngineOptions(engine="inline"))
    return tmp_path / "first", tmp_path / "second"


def change(folder: Path, x: int, row: Any, status: str = "done") -> None:
    for path in (folder / "cells").iterdir():
        entries = json.loads(path.read_text())
        if entries["case"] == {"x": x}:
            error = None if status == "done" else {"what": "changed"}
            entries |= {"row": row, "status": status, "error": error}
            path.write_text(json.dumps(entries))


def test_rows_are_told_apart_cell_by_cell(two: tuple[Path, Path]) -> None:
    found = compare(*two)
    # 1 is refused in both, 6 and 7 have equal rows, one of whose numbers is no number.
    assert found.same == 3
    assert found.different == ()
    # 2 and 3 failed in both, 4 in the second: none of them has a row.
    assert found.missing_first == ()
    assert found.missing_second == ("x=0",)
    assert not found.equal
    assert compare(two[0], two[0]).equal


def test_a_difference_says_where_and_by_how_much(two: tuple[Path, Path]) -> None:
    change(two[0], 6, {"x": 6, "legs": [{"mass": 1.5}, {"mass": 2.0}], "seconds": 1.0, "ok": True})
    change(two[1], 6, {"x": 6, "legs": [{"mass": 1.5}, {"mass": 2.25}], "seconds": 9.0, "ok": 1})
    change(two[1], 7, None, "refused")
    found = compare(*two, without={"seconds"})
    (six, differences), (seven, statuses) = found.different
    # 1 is True in Python, and not in JSON.
    assert (six, seven) == ("x=6", "x=7")
    assert differences == (
        RowDifference(entry="legs[1].mass", first=2.0, second=2.25),
        RowDifference(entry="ok", first=True, second=1),
    )
    assert [each.by for each in differences] == [0.25, None]
    assert statuses == (RowDifference(entry="status", first="done", second="refused"),)


def test_an_entry_that_only_one_has_is_a_difference(two: tuple[Path, Path]) -> None:
    change(two[0], 6, {"x": 6, "error": None})
    change(two[1], 6, {"x": 6, "legs": [1]})
    (_, differences), *_ = compare(*two).different
    assert differences == (
        RowDifference(entry="error", first=None, second=None, only="first"),
        RowDifference(entry="legs", first=None, second=[1], only="second"),
    )


@pytest.mark.parametrize("value", ["nothing", None, "", False])
def test_no_value_equals_an_entry_that_is_not_there(two: tuple[Path, Path], value: object) -> None:
    change(two[0], 6, {"x": 6, "note": value})
    change(two[1], 6, {"x": 6})
    (_, differences), *_ = compare(*two).different
    assert differences == (RowDifference(entry="note", first=value, second=None, only="first"),)


@pytest.mark.parametrize(
    ("first", "second", "by"),
    [
        (10**400, 10**400 + 1, 1.0),
        # The greatest float is below 1.8e308.
        (10**400, 1, None),
        (10**400, 1.5, None),
        (10**400, float("inf"), None),
        (2**53, 2**53 + 1, 1.0),
    ],
)
def test_whole_numbers_of_any_size_are_compared(
    first: float, second: float, by: float | None
) -> None:
    assert RowDifference(entry="x", first=first, second=second).by == by


def test_a_folder_without_a_study_is_refused(two: tuple[Path, Path], tmp_path: Path) -> None:
    with pytest.raises(StudyError, match=r"holds no study.*\n.*`morph study` wrote"):
        compare(two[0], tmp_path)
    (two[1] / "study.json").write_text('{"schema": "other/1"}')
    with pytest.raises(StudyError, match="holds no study: schema 'other/1'"):
        compare(*two)
