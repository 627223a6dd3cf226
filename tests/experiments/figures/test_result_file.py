"""Result files: what may be written into them, and what is found when they are read."""

from __future__ import annotations

import json
import math
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from experiments.engine_options import NO_PART_OF_A_ROW, study_hash
from experiments.figures.result_file import (
    Start,
    is_stale,
    load_result,
    machine,
    save_result,
)
from experiments.figures.result_schema import with_digest
from morph.arrays import JSON
from morph.errors import OutputError, StudyError
from morph.study.code_hash import code_hash

MODULE = "experiments.interval"


@pytest.fixture
def start() -> Start:
    return Start.now(MODULE)


def saved(to: Path, start: Start, **changes: Any) -> JSON:
    values: dict[str, Any] = {
        "command": "experiments.interval --count 3",
        "settings": {"count": 3},
        "seeds": range(2),
        "figures": {"total": 6},
        "controls": {"shuffled": {"total": 5.5}},
        "rows": [{"case": 0, "value": 1.25}, {"case": 1, "value": -3}],
    }
    return load_result(save_result(to, start=start, **{**values, **changes}))


def test_what_is_saved_is_loaded_again(tmp_path: Path, start: Start) -> None:
    result = saved(tmp_path / "one.json", start)
    assert result["figures"] == {"total": 6}
    assert result["controls"] == {"shuffled": {"total": 5.5}}
    assert result["rows"] == [{"case": 0, "value": 1.25}, {"case": 1, "value": -3}]
    assert result["seeds"] == [0, 1]
    assert result["settings"] == {"count": 3}
    assert result["schema"] == "morph.result/2"
    assert result["machine"] == machine()
    assert result["wall_seconds"] >= 0
    assert result["cpu_seconds"] >= 0


def test_a_float_keeps_six_digits_and_an_integer_all(tmp_path: Path, start: Start) -> None:
    figures = {"third": 1 / 3, "large": 1234567.8, "count": 123456789, "tiny": np.float32(1e-30)}
    result = saved(tmp_path / "one.json", start, figures=figures)
    assert result["figures"]["third"] == 0.333333
    assert result["figures"]["large"] == 1234570.0
    assert result["figures"]["count"] == 123456789
    assert result["figures"]["tiny"] == pytest.approx(1e-30, rel=1e-6)


@pytest.mark.parametrize("wrong", [math.nan, np.float64("nan"), np.float32("nan")])
@pytest.mark.parametrize("part", ["figures", "controls", "rows", "settings"])
def test_no_number_is_refused_by_name_and_nothing_is_written(
    tmp_path: Path, start: Start, part: str, wrong: float
) -> None:
    value: Any = {"loss": wrong}
    with pytest.raises(StudyError, match="nan is no figure"):
        saved(tmp_path / "one.json", start, **{part: [value] if part == "rows" else value})
    assert list(tmp_path.iterdir()) == []


def test_what_is_infinite_is_said_in_a_word(tmp_path: Path, start: Start) -> None:
    controls = {"from nothing": {"trials": math.inf}}
    result = saved(tmp_path / "one.json", start, controls=controls)
    assert result["controls"]["from nothing"]["trials"] == "infinite"


@pytest.mark.parametrize("figures", [{}, {"loss": {"median": 1}}, {"loss": [1, 2]}])
def test_figures_are_flat_and_there_are_some(tmp_path: Path, start: Start, figures: JSON) -> None:
    with pytest.raises(StudyError, match="figures"):
        saved(tmp_path / "one.json", start, figures=figures)


def test_figures_without_a_control_are_refused(tmp_path: Path, start: Start) -> None:
    with pytest.raises(StudyError, match="there are no controls"):
        saved(tmp_path / "one.json", start, controls={})


def test_what_json_cannot_hold_is_refused(tmp_path: Path, start: Start) -> None:
    with pytest.raises(StudyError, match="a set is no plain data"):
        saved(tmp_path / "one.json", start, controls={"names": {"a"}})


def test_rows_too_large_to_commit_are_refused(tmp_path: Path, start: Start) -> None:
    rows = [{"case": case, "said": "x" * 90} for case in range(5000)]
    with pytest.raises(StudyError, match="would take 5"):
        saved(tmp_path / "one.json", start, rows=rows)


def test_a_row_takes_a_line_so_that_changes_can_be_read(tmp_path: Path, start: Start) -> None:
    saved(tmp_path / "one.json", start)
    lines = (tmp_path / "one.json").read_text().splitlines()
    assert '  {"case": 1, "value": -3}' in lines


def test_a_result_without_rows_is_json_too(tmp_path: Path, start: Start) -> None:
    assert saved(tmp_path / "one.json", start, rows=[])["rows"] == []


def test_a_folder_that_cannot_be_written_keeps_the_old_result(tmp_path: Path, start: Start) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        saved(tmp_path / "file" / "one.json", start)


def test_a_result_is_stale_once_its_code_has_another_hash(tmp_path: Path, start: Start) -> None:
    assert not is_stale(saved(tmp_path / "one.json", start))
    assert start.code_hash == study_hash(MODULE)
    changed = replace(start, code_hash="0" * 64)
    assert is_stale(saved(tmp_path / "two.json", changed))


def test_a_study_that_is_a_package_depends_on_what_its_main_module_imports() -> None:
    package = "experiments.concealed"
    due = code_hash(f"{package}.__main__", ignore=NO_PART_OF_A_ROW)
    assert study_hash(package) == due != code_hash(package, ignore=NO_PART_OF_A_ROW)


def test_a_result_of_a_study_that_is_gone_is_stale(tmp_path: Path, start: Start) -> None:
    gone = replace(start, module="experiments.gone")
    assert is_stale(saved(tmp_path / "one.json", gone))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "cannot be read"),
        ("[1]", "is not a result"),
        ('{"schema": "x/1"}', "is not a result"),
        ('{"schema": "morph.result/2"}', "field 'code_hash' is missing"),
        ('{"figures": {"loss": NaN}}', "NaN is no number"),
        ('{"figures": {"loss": -Infinity}}', "-Infinity is no number"),
        ("[" * 100_000, "cannot be read"),
        (" " * 400_001, "400000 are read at most"),
    ],
)
def test_a_damaged_result_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "one.json").write_text(text)
    with pytest.raises(StudyError, match=message) as refusal:
        load_result("one", folder=tmp_path)
    assert refusal.value.where == str(tmp_path / "one.json")
    assert "--save" in refusal.value.fix


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("figures", {}),
        ("figures", {"loss": [1]}),
        ("figures", {"loss": None}),
        ("controls", {}),
        ("controls", []),
        ("rows", {}),
        ("seeds", "0"),
        ("command", 3),
        ("commit", "main"),
        ("dirty", "no"),
        ("date", "yesterday"),
        ("wall_seconds", "3"),
        ("wall_seconds", True),
        ("machine", None),
        ("surprise", 1),
    ],
)
def test_a_field_that_no_save_writes_is_refused_although_its_digest_is_right(
    tmp_path: Path, start: Start, field: str, value: Any
) -> None:
    result = saved(tmp_path / "one.json", start) | {field: value}
    (tmp_path / "one.json").write_text(json.dumps(with_digest(result)))
    with pytest.raises(StudyError, match=f"{field}|there are no"):
        load_result("one", folder=tmp_path)


@pytest.mark.parametrize("number", ["1e999", "-1e999"])
def test_a_number_that_overflows_is_refused(tmp_path: Path, start: Start, number: str) -> None:
    saved(tmp_path / "one.json", start)
    text = (tmp_path / "one.json").read_text()
    (tmp_path / "one.json").write_text(text.replace('"total": 6', f'"total": {number}'))
    with pytest.raises(StudyError, match="inf is no figure"):
        load_result("one", folder=tmp_path)


@pytest.mark.parametrize("before", ['"total": 6', '"total": 5.5', '"value": 1.25', '"count": 3'])
def test_a_number_that_is_changed_by_hand_is_found(
    tmp_path: Path, start: Start, before: str
) -> None:
    saved(tmp_path / "one.json", start)
    text = (tmp_path / "one.json").read_text()
    assert text.count(before) == 1
    (tmp_path / "one.json").write_text(text.replace(before, before.partition(" ")[0] + " 7"))
    with pytest.raises(StudyError, match="was changed after it was saved"):
        load_result("one", folder=tmp_path)


def test_a_pipe_is_no_result_and_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "one.json")
    with pytest.raises(StudyError, match="it is a pipe, no regular file"):
        load_result("one", folder=tmp_path)


def test_a_missing_result_is_refused_with_how_to_make_it(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="run its study with --save"):
        load_result("one", folder=tmp_path)
