"""Results of other code: refused, run again, or kept and marked."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from morph.errors import StudyError
from morph.files import sha256
from morph.study import code_hash, manifest, store
from morph.study.cell import Cell, cells_of
from morph.study.engine import EngineOptions
from morph.study.progress import Progress
from morph.study.run import Stale, run
from morph.study.source_watch import SourceWatch
from morph.study.store import Result

HERE = EngineOptions(engine="inline")


class Module:
    """A module of one function that adds a number, on disk and imported anew each time."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.write(1)

    def write(self, number: int) -> None:
        (self.folder / "adding.py").write_text(
            f"from adding_helped import g\ndef f(x): return {{'sum': g(x) + {number}}}\n"
        )
        (self.folder / "adding_helped.py").write_text("def g(x): return x\n")
        self.forget()

    def forget(self) -> None:
        for name in ("adding", "adding_helped"):
            sys.modules.pop(name, None)
        # A second version within a second would else be read from the cache of the first.
        for cached in self.folder.glob("__pycache__/*"):
            cached.unlink()
        code_hash._hash.cache_clear()
        code_hash._closure.cache_clear()

    def sums(self, out: Path, xs: range = range(3), stale: Stale = "refuse") -> list[Result]:
        cells = [Cell(function="adding:f", case={"x": x}) for x in xs]
        return run(cells, folder=out, options=HERE, resume=True, stale=stale)


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Module:
    monkeypatch.syspath_prepend(tmp_path)
    return Module(tmp_path)


def rows(results: list[Result]) -> list[int]:
    return [each.row["sum"] for each in results]


def test_results_of_the_same_code_are_used(module: Module, tmp_path: Path) -> None:
    assert rows(module.sums(tmp_path / "out")) == [1, 2, 3]
    module.write(1)
    results = module.sums(tmp_path / "out", range(4))
    assert rows(results) == [1, 2, 3, 4]
    assert not any(each.stale for each in results)


def test_results_of_other_code_are_refused_and_counted(module: Module, tmp_path: Path) -> None:
    module.sums(tmp_path / "out")
    module.write(10)
    with pytest.raises(StudyError, match=r"3 of 3 results .* other code\n.*--stale rerun"):
        module.sums(tmp_path / "out", range(4))


def test_a_change_of_what_is_imported_counts_too(module: Module, tmp_path: Path) -> None:
    module.sums(tmp_path / "out")
    module.forget()
    (tmp_path / "adding_helped.py").write_text("def g(x): return 2 * x\n")
    with pytest.raises(StudyError, match="3 of 3 results"):
        module.sums(tmp_path / "out")


def test_told_to_run_them_again_no_row_is_of_other_code(module: Module, tmp_path: Path) -> None:
    module.sums(tmp_path / "out")
    module.write(10)
    results = module.sums(tmp_path / "out", range(4), stale="rerun")
    assert rows(results) == [10, 11, 12, 13]
    assert not any(each.stale for each in results)
    assert rows(module.sums(tmp_path / "out", range(4))) == [10, 11, 12, 13]


def test_kept_ones_are_marked_and_stay_marked(module: Module, tmp_path: Path) -> None:
    module.sums(tmp_path / "out")
    module.write(10)
    for _ in range(2):
        results = module.sums(tmp_path / "out", range(4), stale="keep")
        assert rows(results) == [1, 2, 3, 13]
        assert [each.stale for each in results] == [True, True, True, False]


def test_what_ends_after_the_code_was_changed_is_marked(module: Module, tmp_path: Path) -> None:
    cells = [Cell(function="adding:f", case={"x": x}) for x in range(3)]

    def watch(progress: Progress, result: Result | None) -> None:
        if progress.done == 1:
            file = tmp_path / "adding_helped.py"
            file.write_text("def g(x): return 100\n")
            # As an editor that saves a second later.
            os.utime(file, ns=(0, file.stat().st_mtime_ns + 10**9))

    results = run(cells, folder=tmp_path / "out", options=HERE, watch=watch)
    assert [each.stale for each in results] == [False, True, True]
    # The code is put back: the mark stays, since nobody knows what those two ran.
    module.write(1)
    results = module.sums(tmp_path / "out", stale="keep")
    assert [each.stale for each in results] == [False, True, True]


def test_a_change_of_declared_data_is_a_change_of_code(module: Module, tmp_path: Path) -> None:
    data = tmp_path / "masses.csv"
    data.write_text("1,2\n")

    def cell() -> Cell:
        return Cell(function="adding:f", case={"x": 1}, data=(data,))

    first = cell()
    assert (cell().identity, cell().code) == (first.identity, first.code)
    data.write_text("1,3\n")
    assert cell().identity == first.identity
    assert cell().code != first.code
    data.unlink()
    with pytest.raises(StudyError, match=r"masses\.csv: .*No such file"):
        _ = cell().code


def test_begun_anew_nothing_of_before_is_left(module: Module, tmp_path: Path) -> None:
    module.sums(tmp_path / "out")
    module.write(10)
    cells = [Cell(function="adding:f", case={"x": 0})]
    results = run(cells, folder=tmp_path / "out", options=HERE, fresh=True)
    assert rows(results) == [10]
    assert len(list((tmp_path / "out" / "cells").iterdir())) == 1
    with pytest.raises(StudyError, match="exclude each other"):
        run(cells, folder=tmp_path / "out", options=HERE, fresh=True, resume=True)


def test_rows_of_a_source_that_changes_while_it_is_hashed_are_marked(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def edited(*args: Any, **kwargs: Any) -> Path:
        path = manifest.save_manifest(*args, **kwargs)
        with Path("toy_cells.py").open("a") as file:
            file.write("\n")
        return path

    monkeypatch.setattr(sys.modules["morph.study.run"], "save_manifest", edited)
    cells = cells_of(toy.square, [{"x": 1}, {"x": 2}])
    results = run(cells, folder=tmp_path / "out")
    assert [each.stale for each in results] == [True, True]


def test_data_are_read_once_for_all_cells(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data = tmp_path / "table.csv"
    data.write_text("1,2\n")
    read: list[Path] = []

    def counted(*parts: bytes | str | Path) -> str:
        read.extend(part for part in parts if isinstance(part, Path))
        return sha256(*parts)

    monkeypatch.setattr("morph.study.cell.sha256", counted)
    run(cells_of(toy.square, [{"x": x} for x in range(9)], data=[data]), folder=tmp_path / "out")
    assert read == [data]


@pytest.mark.parametrize("path", ["/dev/zero", "/dev", "nowhere.csv"])
def test_data_that_are_no_regular_file_are_refused_in_words(toy: ModuleType, path: str) -> None:
    why = {
        "/dev/zero": "it is a character device",
        "/dev": "it is a folder",
        "nowhere.csv": "No such file",
    }[path]
    (cell,) = cells_of(toy.square, [{"x": 1}], data=[Path(path)])
    with pytest.raises(StudyError, match=f"{path}: declared as data, but cannot be read: {why}"):
        _ = cell.code


def test_the_source_is_looked_at_now_and_then_and_not_for_every_cell(
    module: Module, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.study.scheduler.TICK", 1e9)
    looks: list[SourceWatch] = []
    look = SourceWatch.look

    def counted(self: SourceWatch) -> bool:
        looks.append(self)
        return look(self)

    monkeypatch.setattr(SourceWatch, "look", counted)
    cells = [Cell(function="adding:f", case={"x": x}) for x in range(20)]

    def watch(progress: Progress, result: Result | None) -> None:
        if progress.done == 10:
            module.write(2)

    results = run(cells, folder=tmp_path / "out", options=HERE, watch=watch)
    # After the first cell, and in the end: what ended in between may have run either source.
    assert len(looks) == 2
    assert [each.stale for each in results] == [False] + [True] * 19
    loaded = store.load(tmp_path / "out", cells)
    assert [loaded[each.identity].stale for each in cells] == [False] + [True] * 19
