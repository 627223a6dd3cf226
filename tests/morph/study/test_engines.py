"""The same cells on every engine, and what becomes of workers and schedulers that die."""

from __future__ import annotations

import io
import logging
import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest

from experiments.dask_cluster import start_cluster, start_scheduler
from morph.errors import StudyError
from morph.study import code_hash, dask_engine
from morph.study.cell import Cell, cells_of
from morph.study.engine import ENGINES, Engine, EngineName, EngineOptions
from morph.study.inline import InlineEngine
from morph.study.progress import Progress
from morph.study.run import run
from morph.study.store import Result


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler with two workers, each in a process of its own, over TCP."""
    # After two deaths the scheduler gives a call back.
    settings = {"DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "1"}
    with start_cluster(workers=2, settings=settings) as scheduler:
        yield scheduler.address


@pytest.fixture
def options(request: pytest.FixtureRequest) -> Callable[[EngineName], EngineOptions]:
    """Options by the engine's name; `dask` is the scheduler."""

    def of(engine: EngineName) -> EngineOptions:
        if engine == "dask":
            return EngineOptions(engine=engine, scheduler=request.getfixturevalue("address"))
        return EngineOptions(engine=engine)

    return of


Options = Callable[[EngineName], EngineOptions]


@pytest.mark.parametrize("engine", [each for each in ENGINES if each != "slurm"])
def test_every_engine_gives_the_same_rows(
    toy: ModuleType, tmp_path: Path, options: Options, engine: EngineName
) -> None:
    cells = cells_of(toy.spoiled, [{"x": x} for x in range(3)], path=[Path.cwd()])
    cells += cells_of(toy.added, [toy.Pair(1, (2,))], path=[Path.cwd()])
    results = run(cells, folder=tmp_path / "out", options=options(engine))
    assert [each.status for each in results] == ["done", "refused", "failed", "done"]
    assert repr([each.row for each in results]) == (
        "[{'x': 0, 'error': nan}, None, None, {'sum': 3, 'pair': {'left': 1, 'right': [2]}}]"
    )
    assert not any(each.stale for each in results)


@pytest.mark.parametrize("engine", ["dask", "submitit-local"])
def test_a_cell_that_kills_its_worker_is_quarantined_and_all_others_finish(
    toy: ModuleType, tmp_path: Path, marks: Path, options: Options, engine: EngineName
) -> None:
    cases = [{"x": x, "marks": str(marks), "of": [1]} for x in range(2)]
    results = run(
        cells_of(toy.deadly, cases, path=[Path.cwd()]),
        folder=tmp_path / "out",
        options=options(engine),
    )
    assert [each.status for each in results] == ["done", "quarantined"]
    assert results[0].row == {"x": 0}


def killing(ready: Path, gate: Path, *, times: int) -> Callable[[Progress, Result | None], None]:
    """Return what kills so many workers, each while it runs a cell, and then opens the gate."""
    killed: set[str] = set()

    def watch(progress: Progress, result: Result | None) -> None:
        for path in sorted(ready.iterdir()):
            if path.name not in killed and len(killed) < times:
                killed.add(path.name)
                os.kill(int(path.suffix[1:]), signal.SIGKILL)
        if len(killed) == times:
            gate.touch()

    return watch


def gated(toy: ModuleType, gate: Path, ready: Path, count: int) -> list[Cell]:
    cases = [{"x": x, "gate": str(gate), "ready": str(ready)} for x in range(count)]
    return cells_of(toy.waiting, cases, path=[Path.cwd()])


def test_three_workers_of_a_scheduler_are_killed_and_no_row_is_lost(
    toy: ModuleType, tmp_path: Path, marks: Path, address: str
) -> None:
    gate = tmp_path / "gate"
    results = run(
        gated(toy, gate, marks, 6),
        folder=tmp_path / "out",
        options=EngineOptions(engine="dask", scheduler=address),
        watch=killing(marks, gate, times=3),
    )
    assert [each.row for each in results] == [{"x": x} for x in range(6)]
    # Three starts more than cells, one for each that was killed.
    assert len(list(marks.iterdir())) == 6 + 3


def test_a_worker_with_other_source_is_refused(
    toy: ModuleType, tmp_path: Path, address: str
) -> None:
    def cells() -> list[Cell]:
        code_hash._hash.cache_clear()
        code_hash._closure.cache_clear()
        cases = [{"x": x} for x in range(2)]
        return [Cell(function="edited_cells:f", case=case, path=(Path.cwd(),)) for case in cases]

    def ran(folder: str) -> list[Result]:
        return run(
            cells(),
            folder=tmp_path / folder,
            options=EngineOptions(engine="dask", scheduler=address),
        )

    Path("edited_cells.py").write_text("def f(x): return {'x': x}\n")
    # Twice, so that each worker may have loaded it.
    assert [each.row for each in (*ran("first"), *ran("second"))] == [{"x": 0}, {"x": 1}] * 2
    Path("edited_cells.py").write_text("def f(x): return {'x': x + 1}\n")
    with pytest.raises(StudyError, match=r"other source of edited_cells\n.*workers anew"):
        ran("third")
    sys.modules.pop("edited_cells", None)


@pytest.fixture
def dask_log() -> Iterator[logging.StreamHandler[io.StringIO]]:
    """What Dask logs."""
    handler = logging.StreamHandler(io.StringIO())
    logging.getLogger("distributed").addHandler(handler)
    yield handler
    logging.getLogger("distributed").removeHandler(handler)


def test_a_scheduler_that_goes_away_is_told_and_what_had_ended_is_kept(
    toy: ModuleType, tmp_path: Path, marks: Path, dask_log: logging.StreamHandler[io.StringIO]
) -> None:
    gate = tmp_path / "gate"
    cells = cells_of(toy.square, [{"x": x} for x in range(2)], path=[Path.cwd()])
    cells += gated(toy, gate, marks, 4)
    with start_cluster(workers=1) as scheduler:

        def watch(progress: Progress, result: Result | None) -> None:
            if progress.done == 2 and scheduler.process.poll() is None:
                scheduler.process.kill()
                scheduler.process.wait()

        with pytest.raises(StudyError, match=r"scheduler is gone.*\n.*--resume"):
            run(
                cells,
                folder=tmp_path / "out",
                options=EngineOptions(engine="dask", scheduler=scheduler.address),
                watch=watch,
            )
    # The error that ends the study says it; afterwards Dask logs as before.
    assert (dask_log.stream.getvalue(), dask_log.level) == ("", logging.NOTSET)
    assert len(list((tmp_path / "out" / "cells").iterdir())) == 2
    gate.touch()
    results = run(
        cells, folder=tmp_path / "out", options=EngineOptions(engine="inline"), resume=True
    )
    assert [each.row["x"] for each in results] == [0, 1, 0, 1, 2, 3]


@pytest.mark.parametrize("wakes", [True, False])
def test_a_frozen_scheduler_is_reported_and_the_study_goes_on_if_it_wakes(
    toy: ModuleType, tmp_path: Path, marks: Path, monkeypatch: pytest.MonkeyPatch, wakes: bool
) -> None:
    gate, silences = tmp_path / "gate", list[float]()
    with start_cluster(workers=1) as scheduler:

        def watch(progress: Progress, result: Result | None) -> None:
            if not silences and list(marks.iterdir()):
                os.kill(scheduler.process.pid, signal.SIGSTOP)
                monkeypatch.setattr(dask_engine, "ANSWER_TIMEOUT", 0.2)
                monkeypatch.setattr(dask_engine, "LOST_TIMEOUT", 3600.0 if wakes else 0.3)
                silences.append(0.0)
            elif silences and progress.silent and wakes:
                silences.append(progress.silent)
                os.kill(scheduler.process.pid, signal.SIGCONT)
                monkeypatch.setattr(dask_engine, "ANSWER_TIMEOUT", 10.0)
                gate.touch()

        def ran() -> list[Result]:
            return run(
                gated(toy, gate, marks, 2),
                folder=tmp_path / "out",
                options=EngineOptions(engine="dask", scheduler=scheduler.address),
                watch=watch,
            )

        if wakes:
            assert [each.row for each in ran()] == [{"x": 0}, {"x": 1}]
            assert silences[1] > 0.2
        else:
            monkeypatch.setattr(dask_engine, "CONNECT_TIMEOUT", 5.0)
            with pytest.raises(StudyError, match=r"gone: no answer for 0 s\n.*--resume"):
                ran()


def test_a_scheduler_that_is_not_there_is_named(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_engine, "CONNECT_TIMEOUT", 0.2)
    for address in ("tcp://127.0.0.1:1", "nowhere://x"):
        with pytest.raises(StudyError, match=f"scheduler {address}: no Dask scheduler"):
            run(
                cells_of(toy.square, [{"x": 1}]),
                folder=tmp_path / "out",
                options=EngineOptions(engine="dask", scheduler=address),
            )
    assert not (tmp_path / "out").exists()


def test_a_scheduler_without_workers_is_not_waited_for_in_vain(
    toy: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dask_engine, "EMPTY_TIMEOUT", 0.0)
    monkeypatch.setattr(dask_engine, "POLL_INTERVAL", 0.0)
    with (
        start_scheduler() as scheduler,
        pytest.raises(StudyError, match="has had no workers"),
    ):
        run(
            cells_of(toy.square, [{"x": 1}]),
            folder=tmp_path / "out",
            options=EngineOptions(engine="dask", scheduler=scheduler.address),
        )


@pytest.mark.parametrize("library", ["distributed", "submitit"])
def test_a_missing_library_is_named_with_the_way_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, library: str
) -> None:
    module = {"distributed": "dask_engine", "submitit": "submitit_engine"}[library]
    engine: EngineName = "dask" if library == "distributed" else "slurm"
    monkeypatch.setitem(sys.modules, library, None)
    for name in (module, "slurm"):
        monkeypatch.delitem(sys.modules, f"morph.study.{name}", raising=False)
    with pytest.raises(StudyError, match=rf"{library}.*\n.*'morph-robotics\[cluster\]'"):
        EngineOptions(engine=engine).start(tmp_path)


def test_only_dask_has_a_scheduler_and_only_slurm_asks_for_jobs() -> None:
    with pytest.raises(StudyError, match=r"local has no scheduler\n.*--engine dask"):
        EngineOptions(scheduler="tcp://127.0.0.1:8786")
    with pytest.raises(StudyError, match=r"local asks for no jobs\n.*--engine slurm"):
        EngineOptions(job={"mem_gb": 4})


def test_an_engine_that_leaves_a_method_out_cannot_be_made() -> None:
    class Half(InlineEngine):
        slots = Engine.slots

    with pytest.raises(TypeError, match=r"abstract method '?slots"):
        Half()
