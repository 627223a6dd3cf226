"""Run a study: cells on an engine, results in a folder from which `--resume` continues."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Literal

from morph.errors import StudyError
from morph.run_folder import lock_run_folder
from morph.study.cell import Cell, check_cells
from morph.study.engine import Engine, EngineOptions
from morph.study.inline import InlineEngine
from morph.study.manifest import check_folder, save_manifest, save_rows
from morph.study.progress import Progress, Watch, ignore
from morph.study.scheduler import Scheduler
from morph.study.source_watch import SourceWatch
from morph.study.store import FINAL, Result, clear, count, load

Stale = Literal["refuse", "rerun", "keep"]
"""Policy for results of other code: raise an error, run the cell again, or keep and mark them."""

LOCAL = EngineOptions()
"""Two processes of this machine."""


def run(
    cells: Sequence[Cell],
    *,
    folder: Path,
    name: str = "study",
    options: EngineOptions = LOCAL,
    resume: bool = False,
    fresh: bool = False,
    stale: Stale = "refuse",
    watch: Watch = ignore,
) -> list[Result]:
    """Return the result of every cell, in the order of `cells`; `rows.json` holds all of them.

    With `resume`, cells that are done or refused are not run; failed and quarantined ones are.

    Args:
        cells: Cells to run, no two equal.
        folder: Folder of the manifest and of one file a cell: empty, or of an earlier run.
        name: Name of the study.
        options: Engine that runs the cells; by default two processes of this machine.
        resume: Whether results in the folder are used.
        fresh: Whether results in the folder are deleted.
        stale: With `resume`, the policy for results of other code.
        watch: Called with the progress and each new result, or None where there is no new one.

    Raises:
        StudyError: The cells cannot be run here, the folder cannot be used, or the engine was
            lost; saved results stay.
        OutputError: The folder is in use, or a result cannot be written; saved results stay.
    """
    check_cells(cells)
    sources = SourceWatch(cells)
    with lock_run_folder(folder):
        results = _reusable(folder, cells, name, resume=resume, fresh=fresh, stale=stale)
        progress = Progress(total=len(cells), reused=len(results))
        watch(progress, None)
        remaining = [cell for cell in cells if cell.identity not in results]
        with _start(options, folder, needed=bool(remaining)) as engine:
            if fresh:
                clear(folder)
            save_manifest(folder, cells, name=name, engine=options.as_json())
            results |= Scheduler(engine, folder, progress, watch, sources).run(remaining)
        ordered = [results[cell.identity] for cell in cells]
        save_rows(folder, ordered)
    return ordered


@contextmanager
def _start(options: EngineOptions, folder: Path, *, needed: bool) -> Iterator[Engine]:
    """Yield the started engine, which is shut down in the end; inline where nothing is to run."""
    engine = options.start(folder) if needed else InlineEngine()
    try:
        yield engine
    finally:
        engine.shutdown(cancel_futures=True)


def _reusable(
    folder: Path, cells: Sequence[Cell], name: str, *, resume: bool, fresh: bool, stale: Stale
) -> dict[str, Result]:
    if resume and fresh:
        raise StudyError(
            "--resume and --fresh exclude each other", where="morph.study", fix="leave one out"
        )
    check_folder(folder, cells, name=name, resume=resume)
    if fresh:
        return {}
    present = count(folder)
    if present and not resume:
        raise StudyError(
            f"the folder holds {present} results",
            where=str(folder),
            fix="add --resume to use them, --fresh to delete them, or choose a new folder",
        )
    results = {name: one for name, one in load(folder, cells).items() if one.status in FINAL}
    old = [name for name, one in results.items() if one.stale]
    if old and stale == "refuse":
        raise StudyError(
            f"{len(old)} of {len(results)} results in the folder were made by other code",
            where=str(folder),
            fix="choose a new folder, or add --stale rerun to run them again, or --stale keep",
        )
    if stale == "rerun":
        return {name: one for name, one in results.items() if not one.stale}
    return results
