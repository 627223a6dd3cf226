"""What a worker answers, and where a cell's own words go."""

from __future__ import annotations

import importlib
import json
import os
import py_compile
import sys
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from morph.study.cell import Cell
from morph.study.code_hash import RUNNERS
from morph.study.engine import EngineName, EngineOptions
from morph.study.isolation import SourceLoader, isolated
from morph.study.run import run
from morph.study.worker import MAX_MESSAGE, MAX_TRACE, run_cell

WORDY = """
import os, subprocess
from morph.errors import TaskError

def speak(x):
    print("by print")
    os.write(1, b"by the system\\n")
    subprocess.run(["echo", "by a program"])
    return {"x": x}

def complain(x):
    if x:
        raise ValueError("v" * 1_000_000)
    raise TaskError("w" * 1_000_000, where="wordy", fix="f" * 1_000_000)

def interrupt(x):
    raise KeyboardInterrupt
"""


@pytest.fixture
def wordy(toy: ModuleType) -> None:
    Path("wordy_cells.py").write_text(WORDY)


def answer(function: str, x: int) -> Any:
    job = {"function": function, "case": {"x": x}, "path": [], "code": {}, "ignore": RUNNERS}
    return json.loads(run_cell(json.dumps(job)))


@pytest.mark.usefixtures("wordy")
@pytest.mark.parametrize("engine", ["local", "inline"])
def test_what_a_cell_prints_goes_to_the_error_stream(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], engine: EngineName
) -> None:
    cells = [Cell(function="wordy_cells:speak", case={"x": x}) for x in range(2)]
    run(cells, folder=tmp_path / "out", options=EngineOptions(engine=engine, workers=1))
    out, error = capfd.readouterr()
    assert out == ""
    assert sorted(error.split("\n")) == ["", *sorted(2 * WORDS)]
    # What is printed afterwards is the study's.
    os.write(1, b"rows\n")
    assert capfd.readouterr().out == "rows\n"


WORDS = ["by print", "by the system", "by a program"]


@pytest.mark.usefixtures("wordy")
def test_a_message_of_a_million_letters_is_cut() -> None:
    failed = answer("wordy_cells:complain", 1)
    assert failed["error"]["what"] == f"ValueError: {'v' * MAX_MESSAGE}"[:MAX_MESSAGE]
    assert len(failed["error"]["trace"]) == MAX_TRACE
    refused = answer("wordy_cells:complain", 0)
    assert refused["status"] == "refused"
    assert {name: len(part) for name, part in refused["error"].items()} == {
        **{"what": MAX_MESSAGE, "where": len("wordy"), "fix": MAX_MESSAGE}
    }


STRAY = """
import asyncio, os
from pathlib import Path

def move(x, to):
    os.chdir(to)
    return {"x": x}

def double(x, marks):
    child = os.fork()
    if child:
        os.waitpid(child, 0)
    with open(Path(marks) / str(x), "a") as file:
        file.write("returns\\n")
    if child == 0 and x == 1:
        raise KeyboardInterrupt
    return {"x": x, "child": child == 0}

def cancel(x):
    raise asyncio.CancelledError("by itself")
"""


@pytest.fixture
def stray(toy: ModuleType) -> None:
    Path("stray_cells.py").write_text(STRAY)


@pytest.mark.usefixtures("stray")
def test_a_cell_that_changes_the_folder_moves_no_row(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    before = Path.cwd()
    cells = [
        Cell(function="stray_cells:move", case={"x": x, "to": str(elsewhere)}) for x in range(2)
    ]
    results = run(cells, folder=Path("out"), options=EngineOptions(engine="inline"))
    assert [each.row for each in results] == [{"x": 0}, {"x": 1}]
    assert Path.cwd() == before
    assert list(elsewhere.iterdir()) == []
    assert len(list((before / "out" / "cells").iterdir())) == 2


@pytest.mark.usefixtures("stray")
@pytest.mark.parametrize("engine", ["inline", "local", "submitit-local"])
def test_a_cell_that_forks_has_one_answer_and_its_study_goes_on_once(
    tmp_path: Path, marks: Path, engine: EngineName
) -> None:
    cells = [
        Cell(function="stray_cells:double", case={"x": x, "marks": str(marks)}) for x in range(3)
    ]
    results = run(cells, folder=tmp_path / "out", options=EngineOptions(engine=engine))
    assert [each.row for each in results] == [{"x": x, "child": False} for x in range(3)]
    # Once in the child, once in the parent, and never again by a second study.
    assert [(marks / str(x)).read_text() for x in range(3)] == ["returns\n" * 2] * 3


@pytest.mark.usefixtures("stray")
def test_a_cell_that_cancels_itself_has_failed() -> None:
    failed = answer("stray_cells:cancel", 1)
    assert (failed["status"], failed["error"]["what"]) == ("failed", "CancelledError: by itself")


@pytest.mark.parametrize("engine", ["inline", "local", "submitit-local"])
def test_bytecode_of_older_source_of_the_same_size_and_second_is_not_run(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, engine: EngineName
) -> None:
    for name in ("aged_cells", "aged_part"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    Path("aged_part.py").write_text("V = 1\n")
    modified = Path("aged_part.py").stat().st_mtime_ns
    py_compile.compile("aged_part.py", doraise=True)
    Path("aged_part.py").write_text("V = 7\n")
    os.utime("aged_part.py", ns=(modified, modified))
    Path("aged_cells.py").write_text("import aged_part\ndef f(x): return aged_part.V * x\n")
    importlib.invalidate_caches()
    cells = [Cell(function="aged_cells:f", case={"x": 2}, path=(Path.cwd(),))]
    (result,) = run(cells, folder=tmp_path / "out", options=EngineOptions(engine=engine))
    assert result.row == 14


def test_the_finder_of_sources_goes_and_uses_the_bytecode_of_what_is_installed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # A finder of the old protocol has no `find_spec`.
    monkeypatch.setattr(sys, "meta_path", [object(), *sys.meta_path])
    before = list(sys.meta_path)
    with isolated():
        (finder,) = set(sys.meta_path) - set(before)
        assert type(finder.find_spec("loky", None).loader) is SourceFileLoader
        assert type(finder.find_spec("morph", None).loader) is SourceLoader
        assert finder.find_spec("nowhere_at_all", None) is None
    assert sys.meta_path == before


@pytest.mark.usefixtures("wordy")
def test_ctrl_c_is_no_answer() -> None:
    with pytest.raises(KeyboardInterrupt):
        answer("wordy_cells:interrupt", 1)
