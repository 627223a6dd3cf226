"""`morph study` as a program: what it writes, says and returns."""

from __future__ import annotations

import json
import re
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from morph.app.cli.main import main
from morph.study import code_hash
from morph.study.file import StudyFile

CELLS = """
from morph.errors import TaskError

def square(x):
    if x == 3:
        raise KeyError("three")
    if x == 4:
        raise TaskError("four is too many", where="cells", fix="take three")
    return {"x": x, "square": x * x}
"""

MESSAGE = re.compile(r"error: (?P<where>.+?): (?P<what>.+)\n  fix: (?P<fix>.+)\n")


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.delitem(sys.modules, "square_cells", raising=False)
    (tmp_path / "square_cells.py").write_text(CELLS)
    path = tmp_path / "squares.toml"
    path.write_text('function = "square_cells:square"\n[grid]\nx = "0:3"\n')
    return path


def asked(study: Path, *options: str) -> int:
    return main(["study", str(study), "--engine", "inline", *options])


def test_it_writes_the_rows_in_order_and_says_where(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert asked(study) == 0
    assert capsys.readouterr().out == "3 cells: 3 done\nrows: out/squares/rows.json\n"
    told = json.loads(Path("out/squares/rows.json").read_text())
    assert told["schema"] == "morph.rows/1"
    assert [each["row"] for each in told["rows"]] == [{"x": x, "square": x * x} for x in range(3)]
    assert [each["case"] for each in told["rows"]] == [{"x": x} for x in range(3)]


def test_progress_goes_to_the_error_stream_in_plain_lines(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert asked(study, "--json") == 0
    out, error = capsys.readouterr()
    assert json.loads(out)["schema"] == "morph.rows/1"
    assert "3 of 3 done, 0 running, 0 failed, 0 workers lost" in error
    assert asked(study, "--json", "--fresh", "--quiet") == 0
    assert capsys.readouterr().err == ""


def test_a_cell_that_failed_is_named_and_the_status_is_3(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study.write_text(study.read_text().replace("0:3", "2:5"))
    assert asked(study) == 3
    out, error = capsys.readouterr()
    assert "3 cells: 1 done, 1 failed, 1 refused" in out
    assert "failed: x=3: KeyError: 'three'" in out
    assert "refused: x=4: four is too many" in out
    assert "failed: x=3: KeyError: 'three'" in error
    assert "x=4" not in error


def test_a_cell_that_was_refused_alone_is_a_result(study: Path) -> None:
    study.write_text(study.read_text().replace("0:3", "4:5"))
    assert asked(study) == 0


def test_a_second_run_is_refused_resumed_or_begun_anew(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert asked(study) == 0
    assert asked(study) == 2
    assert "the folder holds 3 results" in capsys.readouterr().err
    assert asked(study, "--resume") == 0
    assert asked(study, "--fresh") == 0


def test_two_runs_are_compared(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert asked(study) == 0
    assert asked(study, "--out", "other", "--against", "out/squares") == 0
    assert "3 cells the same, 0 different" in capsys.readouterr().out
    (kept,) = [p for p in Path("other/cells").iterdir() if '"square": 4' in p.read_text()]
    kept.write_text(kept.read_text().replace('"square": 4', '"square": 4.5'))
    assert asked(study, "--out", "other", "--resume", "--against", "out/squares") == 3
    assert "x=2: square 4.5 and 4, 0.5 apart" in capsys.readouterr().out
    assert asked(study, "--resume", "--against", "other", "--ignore", "square", "--json") == 0
    assert json.loads(capsys.readouterr().out)["same"] == 3


def test_an_entry_that_one_run_alone_has_is_named_with_the_run(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for out in ("one", "two"):
        assert asked(study, "--out", out) == 0
    (kept,) = [p for p in Path("two/cells").iterdir() if '"square": 4' in p.read_text()]
    kept.write_text(kept.read_text().replace('"square": 4', '"note": "nothing"'))
    capsys.readouterr()
    assert asked(study, "--out", "one", "--resume", "--against", "two") == 3
    out = capsys.readouterr().out
    assert "x=2: square 4 in this run only\n" in out
    assert "x=2: note 'nothing' in --against only\n" in out


def test_a_study_is_not_compared_with_itself(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert asked(study) == 0
    before = Path("out/squares/rows.json").read_bytes()
    capsys.readouterr()
    assert asked(study, "--fresh", "--against", "./out/../out/squares") == 2
    assert "out/squares would be compared with itself" in capsys.readouterr().err
    assert Path("out/squares/rows.json").read_bytes() == before


@pytest.mark.parametrize("name", ["study.json", "rows.json", "thesis.tex"])
def test_a_file_of_the_user_s_is_not_replaced(
    study: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    Path("mine").mkdir()
    Path("mine", name).write_text("{}")
    assert asked(study, "--out", "mine") == 2
    assert f"error: mine: the folder holds {name}, which no study wrote" in capsys.readouterr().err
    assert {path.name: path.read_text() for path in Path("mine").iterdir()} == {name: "{}"}


def test_what_cells_print_is_not_among_the_rows(
    study: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("square_cells.py").write_text("def square(x):\n    print('hello')\n    return x\n")
    assert asked(study, "--json", "--quiet") == 0
    assert [each["row"] for each in json.loads(capfd.readouterr().out)["rows"]] == [0, 1, 2]


def test_what_a_module_prints_when_it_is_imported_is_not_among_the_rows(
    study: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("square_cells.py").write_text("print('hello')\ndef square(x):\n    return x\n")
    assert asked(study, "--json", "--quiet") == 0
    out, error = capfd.readouterr()
    assert [each["row"] for each in json.loads(out)["rows"]] == [0, 1, 2]
    assert error == "hello\n"


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("import sys\nsys.exit(0)\n", "SystemExit: 0"),
        ("import asyncio\nraise asyncio.CancelledError('x')\n", "CancelledError: x"),
        ("x = [].nothing\n", "AttributeError: 'list' object has no attribute 'nothing'"),
    ],
)
def test_a_module_that_ends_the_program_when_it_is_imported_is_refused(
    study: Path, capsys: pytest.CaptureFixture[str], text: str, what: str
) -> None:
    Path("square_cells.py").write_text(text)
    assert asked(study) == 2
    assert f"'square_cells' cannot be imported: {what}" in capsys.readouterr().err


def test_a_module_of_the_current_folder_counts_where_the_file_lies_elsewhere(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "current").mkdir()
    monkeypatch.chdir(tmp_path / "current")
    monkeypatch.delitem(sys.modules, "current_cells", raising=False)
    (tmp_path / "square_cells.py").write_text("from current_cells import square\n")
    Path("current_cells.py").write_text("def square(x): return x\n")
    assert asked(study) == 0
    Path("current_cells.py").write_text("def square(x): return x * x\n")
    code_hash._hash.cache_clear()
    assert asked(study, "--resume") == 2
    assert "3 of 3 results in the folder were made by other code" in capsys.readouterr().err


def test_what_to_compare_with_is_looked_at_before_anything_is_run(study: Path) -> None:
    assert asked(study, "--against", "nowhere") == 2
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (("--workers", "0"), "0 workers"),
        (("--workers", "1000000"), "1000000 workers"),
        (("--scheduler", "tcp://127.0.0.1:1"), "has no scheduler"),
        (("--job", "mem_gb=4"), "asks for no jobs"),
        (("--job", "memory"), "--job must be NAME=VALUE, got 'memory'"),
        (("--resume", "--fresh"), "--resume and --fresh exclude each other"),
        (("--out", ""), "--out is empty"),
        (("--out", "squares.toml"), "it is a file, or lies below one"),
        (("--out", "squares.toml/out"), "it is a file, or lies below one"),
    ],
)
def test_options_that_cannot_be_are_refused_in_three_parts(
    study: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, ...], what: str
) -> None:
    assert asked(study, *options) == 2
    matched = MESSAGE.fullmatch(capsys.readouterr().err)
    assert matched
    assert what in matched["what"]


def test_an_unknown_module_or_function_is_refused_in_three_parts(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("nowhere_at_all:square", "square_cells:sqare"):
        study.write_text(f'function = "{name}"\n[grid]\nx = [1]\n')
        assert asked(study) == 2
        matched = MESSAGE.fullmatch(capsys.readouterr().err)
        assert matched
        assert matched["where"] == name


def test_the_function_is_looked_up_before_the_cells_are_made(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    study.write_text('function = "square_cells:sqare"\n[grid]\nx = "0:100000"\n')
    monkeypatch.setattr(StudyFile, "cells", property(lambda file: pytest.fail("cells are made")))
    assert asked(study) == 2
    assert "no function 'sqare'" in capsys.readouterr().err


def test_the_module_is_found_beside_the_file_from_any_folder(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "away").mkdir()
    monkeypatch.chdir(tmp_path / "away")
    assert main(["study", str(study), "--quiet", "--workers", "1"]) == 0


def test_a_file_that_may_not_grow_is_a_message_and_leaves_no_part(study: Path) -> None:
    # A limit on the size of files stands for a full disk: here by a row of 20 kB.
    Path("square_cells.py").write_text("def square(x): return {'x': 'x' * 20_000 * x}\n")
    done = subprocess.run(
        [
            *(sys.executable, "-c", "from morph.app.cli.main import entry; entry()"),
            *("study", str(study), "--engine", "inline", "--quiet"),
        ],
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, 10_000)),
    )
    matched = MESSAGE.fullmatch(done.stderr)
    assert matched, done.stderr
    assert matched["what"] == "cannot write: File too large; 1 results of this run are kept"
    assert matched["fix"] == "make room there, then go on with --resume"
    assert done.returncode == 2
    (kept,) = Path("out/squares/cells").iterdir()
    assert json.loads(kept.read_text())["row"] == {"x": ""}
