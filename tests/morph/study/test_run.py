from __future__ import annotations

import errno
import json
import math
import os
import tempfile
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from morph import files
from morph.errors import MorphError, OutputError, StudyError
from morph.run_folder import lock_run_folder
from morph.study.cell import Cell, cells_of
from morph.study.engine import EngineOptions
from morph.study.inline import InlineEngine
from morph.study.progress import Progress
from morph.study.run import run
from morph.study.store import Result

Starts = Callable[[], dict[str, int]]


def squares(toy: ModuleType, count: int = 6) -> list[Cell]:
    return cells_of(toy.square, [{"x": x} for x in range(count)])


def test_rows_come_in_the_order_of_the_cells_whichever_ends_first(
    toy: ModuleType, tmp_path: Path, marks: Path
) -> None:
    gate = tmp_path / "gate"
    cells = cells_of(toy.waiting, [{"x": 9, "gate": str(gate), "ready": str(marks)}])
    cells += reversed(squares(toy, 3))
    ended: list[int] = []

    def watch(progress: Progress, result: Result | None) -> None:
        if result is not None:
            # The first cell waits until the others have ended.
            ended.append(result.row["x"])
            if len(ended) == 3:
                gate.touch()

    results = run(cells, folder=tmp_path / "out", watch=watch)
    assert ended == [2, 1, 0, 9]
    assert [each.row["x"] for each in results] == [9, 2, 1, 0]
    assert [each.cell for each in results] == cells


def test_two_workers_are_two_processes_and_neither_is_this_one(
    toy: ModuleType, tmp_path: Path, marks: Path
) -> None:
    gate, ready = tmp_path / "gate", marks
    cells = cells_of(
        toy.waiting, [{"x": x, "gate": str(gate), "ready": str(ready)} for x in range(2)]
    )

    def watch(progress: Progress, result: Result | None) -> None:
        # Both run at once, or the gate never opens.
        if len(list(ready.iterdir())) == 2:
            gate.touch()

    run(cells, folder=tmp_path / "out", watch=watch)
    pids = {int(path.name.partition(".")[2]) for path in ready.iterdir()}
    assert len(pids) == 2
    assert os.getpid() not in pids


def test_a_worker_has_one_thread_for_numerical_libraries(toy: ModuleType, tmp_path: Path) -> None:
    (result,) = run(cells_of(toy.threads, [{"x": 1}]), folder=tmp_path / "out")
    assert result.row == {"threads": "1"}


def test_a_dataclass_reaches_the_function_as_it_was_and_a_row_of_one_is_a_mapping(
    toy: ModuleType, tmp_path: Path
) -> None:
    (result,) = run(cells_of(toy.added, [toy.Pair(1, (2, 3))]), folder=tmp_path / "out")
    assert result.row == {"sum": 6, "pair": {"left": 1, "right": [2, 3]}}


def test_each_result_says_what_came_of_its_cell(toy: ModuleType, tmp_path: Path) -> None:
    results = run(cells_of(toy.spoiled, [{"x": x} for x in range(5)]), folder=tmp_path / "out")
    assert [each.status for each in results] == ["done", "refused", "failed", "failed", "failed"]
    errors = [each.error for each in results]
    assert errors[1] == {"what": "a pole of -1 m", "where": "toy", "fix": "make it longer"}
    assert errors[2] is not None
    assert errors[2]["what"] == "KeyError: 'nothing of that name'"
    assert "in spoiled" in errors[2]["trace"]
    assert errors[3] is not None
    assert errors[3]["what"] == "SystemExit: 0"
    assert errors[4] is not None
    assert "row.x is a object" in errors[4]["what"]
    assert math.isnan(results[0].row["error"])


def test_the_files_are_strict_json_and_name_the_code(toy: ModuleType, tmp_path: Path) -> None:
    cells = cells_of(toy.spoiled, [{"x": 0}])
    run(cells, folder=tmp_path / "out", name="spoiling")
    told = json.loads(
        (tmp_path / "out" / "cells" / f"{cells[0].identity}.json").read_text(),
        parse_constant=lambda name: pytest.fail(f"{name} is no JSON"),
    )
    assert told["schema"] == "morph.cell/1"
    assert told["row"] == {"x": 0, "error": {"!float": "nan"}}
    assert told["code"] == cells[0].code
    manifest = json.loads((tmp_path / "out" / "study.json").read_text())
    assert manifest["schema"] == "morph.study/1"
    assert manifest["name"] == "spoiling"
    assert manifest["code"] == {"toy_cells:spoiled": cells[0].code}
    assert [each["identity"] for each in manifest["cells"]] == [cells[0].identity]


def test_a_cell_that_kills_its_worker_is_quarantined_and_all_others_finish(
    toy: ModuleType, tmp_path: Path, marks: Path, starts: Starts
) -> None:
    cases = [{"x": x, "marks": str(marks), "of": [2]} for x in range(6)]
    results = run(cells_of(toy.deadly, cases), folder=tmp_path / "out")
    assert [each.status for each in results] == [*["done"] * 2, "quarantined", *["done"] * 3]
    assert results[2].error is not None
    assert "SIGKILL" in results[2].error["what"]
    # The guilty one had its second chance; nobody else was run again.
    assert starts() == {"0": 1, "1": 1, "2": 2, "3": 1, "4": 1, "5": 1}


def test_cells_whose_workers_were_killed_are_run_again(
    toy: ModuleType, tmp_path: Path, marks: Path, starts: Starts
) -> None:
    cases = [{"x": x, "marks": str(marks), "of": [0, 2, 5]} for x in range(6)]
    seen = []
    results = run(
        cells_of(toy.deadly_once, cases),
        folder=tmp_path / "out",
        watch=lambda progress, result: seen.append(progress.worker_deaths),
    )
    assert [each.row for each in results] == [{"x": x} for x in range(6)]
    assert starts() == {"0": 2, "1": 1, "2": 2, "3": 1, "4": 1, "5": 2}
    assert seen[-1] == 3


def test_workers_that_die_of_nothing_end_the_study_and_blame_no_cell(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("morph.study.local._start_worker", os._exit)
    with pytest.raises(StudyError, match="die before they run anything"):
        run(squares(toy, 2), folder=tmp_path / "out")
    assert list((tmp_path / "out").glob("cells/*")) == []


def test_trouble_of_the_engine_is_borne_once_and_then_told(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[str] = []

    def submit(self: InlineEngine, fn: Callable[[str], str], job: str) -> Future[str]:
        future: Future[str] = Future()
        tried.append(job)
        x = json.loads(job)["case"]["x"]
        if x == 1 and tried.count(job) == 1:
            future.set_exception(TypeError("cannot unpack NoneType"))
        elif x == 2:
            future.set_exception(RuntimeError("lost in transit"))
        else:
            future.set_result(fn(job))
        return future

    monkeypatch.setattr(InlineEngine, "submit", submit)
    results = run(squares(toy, 3), folder=tmp_path / "out", options=EngineOptions(engine="inline"))
    assert [each.status for each in results] == ["done", "done", "failed"]
    assert results[2].error is not None
    assert results[2].error["what"] == "RuntimeError: lost in transit"
    assert [tried.count(job) for job in dict.fromkeys(tried)] == [1, 2, 2]


def test_a_folder_with_results_is_left_alone_without_resume(
    toy: ModuleType, tmp_path: Path
) -> None:
    run(squares(toy, 2), folder=tmp_path / "out")
    with pytest.raises(StudyError, match=r"holds 2 results\n.*--resume"):
        run(squares(toy, 2), folder=tmp_path / "out")


def test_resume_runs_only_what_is_missing_or_failed(
    toy: ModuleType, tmp_path: Path, marks: Path, starts: Starts
) -> None:
    def cells(count: int) -> list[Cell]:
        return cells_of(
            toy.deadly, [{"x": x, "marks": str(marks), "of": [1]} for x in range(count)]
        )

    run(cells(3), folder=tmp_path / "out")
    results = run(cells(4), folder=tmp_path / "out", resume=True)
    assert [each.status for each in results] == ["done", "quarantined", "done", "done"]
    assert starts() == {"0": 1, "1": 4, "2": 1, "3": 1}


def test_a_result_that_somebody_spoilt_is_made_again(toy: ModuleType, tmp_path: Path) -> None:
    cells = squares(toy, 3)
    run(cells, folder=tmp_path / "out")
    kept = [tmp_path / "out" / "cells" / f"{cell.identity}.json" for cell in cells]
    kept[0].write_text(kept[0].read_text()[:40])
    kept[1].write_text(kept[2].read_text())
    results = run(cells, folder=tmp_path / "out", resume=True)
    assert [each.row["square"] for each in results] == [0, 1, 4]


def test_a_full_disk_ends_the_study_with_a_message_and_keeps_what_was_written(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The manifest and two results fit.
    room = [3]
    mkstemp = tempfile.mkstemp

    def full_disk(*args: Any, **kwargs: Any) -> tuple[int, str]:
        room[0] -= 1
        if room[0] < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return mkstemp(*args, **kwargs)

    cells = squares(toy)
    with monkeypatch.context() as full:
        full.setattr(files.tempfile, "mkstemp", full_disk)
        with pytest.raises(OutputError, match=r"No space left.*; 2 results .*\n.*--resume"):
            run(cells, folder=tmp_path / "out")
    left = sorted((tmp_path / "out" / "cells").iterdir())
    assert len(left) == 2
    assert all(json.loads(path.read_text())["status"] == "done" for path in left)
    results = run(cells, folder=tmp_path / "out", resume=True)
    assert [each.row["square"] for each in results] == [0, 1, 4, 9, 16, 25]


def test_two_studies_do_not_write_into_one_folder(toy: ModuleType, tmp_path: Path) -> None:
    with (
        lock_run_folder(tmp_path / "out"),
        pytest.raises(OutputError, match=f"another morph .*process {os.getpid()}"),
    ):
        run(squares(toy), folder=tmp_path / "out")
    assert len(run(squares(toy), folder=tmp_path / "out")) == 6


def test_a_folder_that_cannot_be_made_is_refused(toy: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be locked"):
        run(squares(toy), folder=tmp_path / "file" / "out")


@pytest.mark.parametrize("workers", [0, -1, 10**6])
def test_so_many_workers_are_refused(workers: int) -> None:
    with pytest.raises(StudyError, match=f"{workers} workers\n.*1 to 1024"):
        EngineOptions(workers=workers)


def test_no_cells_are_refused(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="no cells"):
        run([], folder=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_equal_cells_are_refused_by_number(toy: ModuleType, tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="cells 1 and 3 are equal: x=0"):
        run([*squares(toy, 2), *squares(toy, 1)], folder=tmp_path / "out")


@pytest.mark.parametrize(
    ("name", "what"),
    [
        ("toy_cells:sqare", r"no function 'sqare'\n.*square"),
        ("toy_cells:FACTOR", "'FACTOR' is a int"),
        ("nowhere_at_all:f", "No module named 'nowhere_at_all'"),
    ],
)
def test_what_is_no_function_is_refused(
    toy: ModuleType, tmp_path: Path, name: str, what: str
) -> None:
    with pytest.raises(MorphError, match=what):
        run([Cell(function=name, case={"x": 1})], folder=tmp_path / "out")
