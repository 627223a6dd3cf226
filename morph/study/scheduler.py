"""Scheduler of a study: submits cells, saves results, and resubmits cells whose worker died."""

from __future__ import annotations

import json
import queue
import time
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from morph.arrays import JSON
from morph.errors import OutputError, StudyError
from morph.study.cell import Cell
from morph.study.encoding import decode_row
from morph.study.engine import Engine, WorkerDied
from morph.study.progress import Progress, Watch
from morph.study.source_watch import SourceWatch
from morph.study.store import FINAL, Result, Status, save
from morph.study.worker import describe, ping, run_cell, run_cell_in_worker

TICK = 0.5
"""Seconds between checks of the engine while no cell ends, and between checks of the source."""


class Scheduler:
    """Runs cells on an engine and saves each result as it arrives.

    A cell whose worker died is run once more after all others; a second death quarantines it.
    Results saved since the last check of the source wait in `_unchecked`: where the source has
    changed by the next check, they are saved again as stale.
    """

    def __init__(
        self, engine: Engine, folder: Path, progress: Progress, watch: Watch, sources: SourceWatch
    ) -> None:
        self._engine, self._folder = engine, folder
        self._progress, self._watch, self._sources = progress, watch, sources
        self._ended: queue.SimpleQueue[tuple[Cell, Future[str]]] = queue.SimpleQueue()
        self._results: dict[str, Result] = {}
        self._unchecked: list[Result] = []
        self._next_look = 0.0

    def run(self, cells: Sequence[Cell]) -> dict[str, Result]:
        """Return the results of cells by identity.

        Raises:
            StudyError: The engine is lost, or a worker imports other source.
            OutputError: A result cannot be written.
        """
        try:
            suspects = self._run_all(cells, last=False)
            self._run_all(suspects, last=True)
        except BaseException:
            with suppress(StudyError, OutputError):
                self._drain()
            with suppress(OutputError):
                self._check_sources()
            raise
        self._check_sources()
        return self._results

    def _run_all(self, cells: Sequence[Cell], *, last: bool) -> list[Cell]:
        """Run cells, and return those without an answer; in the last attempt these get a result."""
        waiting, running, suspects = deque(cells), 0, list[Cell]()
        while waiting or running:
            slots = 1 if last and self._engine.shared else self._engine.slots()
            while waiting and running < slots:
                self._submit(waiting.popleft())
                running += 1
            self._progress.running = running
            try:
                cell, future = self._ended.get(timeout=TICK)
            except queue.Empty:
                # Raises where the engine is lost, so that nothing would ever end.
                self._engine.slots()
                self._progress.silent = self._engine.silent
                self._check_sources()
                self._watch(self._progress, None)
                continue
            running -= 1
            self._progress.running, self._progress.silent = running, 0.0
            if not self._settle(cell, future, last=last):
                suspects.append(cell)
        return suspects

    def _settle(self, cell: Cell, future: Future[str], *, last: bool) -> bool:
        """Save the result of a cell that ended; return False if it must be run again.

        A cell's own errors are answers: an exception of the future is the engine's.
        """
        error = future.exception()
        self._progress.worker_deaths += isinstance(error, WorkerDied)
        if isinstance(error, StudyError):
            raise error
        if error is None:
            self._save_answer(cell, future.result())
        elif not last:
            return False
        elif isinstance(error, WorkerDied):
            self._quarantine(cell, str(error))
        else:
            self._save(cell, status="failed", error=describe(error))
        return True

    def _submit(self, cell: Cell) -> None:
        job = {
            "function": cell.function,
            "case": cell.encoded,
            "path": [str(each) for each in cell.path],
            "code": cell.code_by_module if self._engine.foreign else {},
            "ignore": cell.ignore,
        }
        call = run_cell_in_worker if self._engine.own_process else run_cell
        future = self._engine.submit(call, json.dumps(job))
        future.add_done_callback(lambda ended: self._ended.put((cell, ended)))

    def _save_answer(self, cell: Cell, answer: str) -> None:
        entries = json.loads(answer)
        if entries["status"] == "other code":
            raise StudyError(
                f"worker {entries['host']} has other source of {entries['error']['what']}",
                where=self._engine.name,
                fix="give every worker this checkout and start the workers anew, then --resume",
            )
        self._save(cell, **entries)

    def _quarantine(self, cell: Cell, why: str) -> None:
        """Save a cell as quarantined, unless workers die without running any cell."""
        future = self._engine.submit(ping)
        while True:
            try:
                future.result(timeout=TICK)
                break
            except NotYet:
                self._engine.slots()
            except WorkerDied as error:
                raise StudyError(
                    f"workers die before they run anything: {error}",
                    where=self._engine.name,
                    fix="see that `python -c 'import morph'` works there, then --resume",
                ) from None
        self._save(cell, status="quarantined", error={"what": f"killed its worker twice: {why}"})

    def _save(
        self,
        cell: Cell,
        *,
        status: Status,
        error: JSON | None,
        row: Any = None,
        seconds: float = 0.0,
        host: str = "",
    ) -> None:
        result = Result(
            cell=cell,
            status=status,
            row=decode_row(row),
            error=error,
            seconds=seconds,
            host=host,
            code=cell.code,
        )
        self._write(result)
        self._progress.done += 1
        self._progress.failed += status not in FINAL
        self._unchecked.append(result)
        if time.monotonic() >= self._next_look:
            self._check_sources()
        self._watch(self._progress, self._results[cell.identity])

    def _check_sources(self) -> None:
        """Mark results since the last check as stale if the source has changed."""
        if self._sources.look():
            for result in self._unchecked:
                self._write(replace(result, stale=True))
        self._unchecked.clear()
        self._next_look = time.monotonic() + TICK

    def _write(self, result: Result) -> None:
        try:
            save(self._folder, result)
        except OutputError as full:
            raise OutputError(
                f"{full.what}; {len(self._results)} results of this run are kept",
                where=str(self._folder),
                fix="make room there, then go on with --resume",
            ) from full
        self._results[result.cell.identity] = result

    def _drain(self) -> None:
        """Save the answers that had arrived but were not saved when the study was stopped."""
        with suppress(queue.Empty):
            while True:
                cell, future = self._ended.get_nowait()
                if future.exception() is None:
                    self._save_answer(cell, future.result())
