"""Command-line options of the study engine, and its use by the studies of this folder."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from morph.arrays import JSON
from morph.errors import MorphError
from morph.study.cell import Cell
from morph.study.code_hash import RUNNERS, code_hash, source_folder
from morph.study.engine import ENGINES, EngineOptions
from morph.study.live import in_words, live
from morph.study.run import run
from morph.study.store import FINAL, Result

DONE, UNUSABLE, STOPPED_SHORT, INTERRUPTED = 0, 2, 3, 130
"""Exit statuses, the same as those of `morph`."""

NO_PART_OF_A_ROW = (
    *RUNNERS,
    *("experiments.engine_options", "experiments.needs", "experiments.figures"),
)
"""Packages left out of a study's code hash: they run its cells, find its data and save its results,
and do not decide what a cell returns, so a change there makes no result stale."""

OF_THE_ENGINE = ("experiments.bench_study",)
"""Studies that measure the engine itself: their code hash leaves nothing out."""


def study_hash(module: str) -> str:
    """Return the hash of the code that a study's figures depend on.

    Args:
        module: What `python -m` runs: a module, or a package by its `__main__`.

    Raises:
        StudyError: There is no such module, or it has no source.
    """
    main = f"{module}.__main__"
    file = source_folder(module).joinpath(*main.split(".")).with_suffix(".py")
    run = main if file.is_file() else module
    return code_hash(run, ignore=() if module in OF_THE_ENGINE else NO_PART_OF_A_ROW)


def add_engine_options(parser: argparse.ArgumentParser, *, out: str) -> None:
    """Add the engine's options to a parser: --engine, --workers, --resume, --out and others.

    Args:
        parser: Parser of the study.
        out: Default of --out, the folder of the cells' results.
    """
    group = parser.add_argument_group("engine")
    group.add_argument("--engine", choices=ENGINES, default="local", help="who runs the cells")
    group.add_argument("--workers", type=int, default=2, help="processes, or jobs at once")
    group.add_argument("--scheduler", help="address of a Dask scheduler: tcp://host:8786")
    begin = group.add_mutually_exclusive_group()
    begin.add_argument("--resume", action="store_true", help="go on with what --out holds")
    begin.add_argument("--fresh", action="store_true", help="begin anew in a used --out")
    group.add_argument(
        "--stale",
        choices=("refuse", "rerun", "keep"),
        default="refuse",
        help="with --resume: what becomes of results of other code",
    )
    group.add_argument("--out", type=Path, default=Path(out), help="folder of the results")


def results_of(cells: Sequence[Cell], options: argparse.Namespace, *, name: str) -> list[Result]:
    """Return the result of every cell, in their order; end the program if one failed.

    The program ends with status 2 where the study cannot be run, 3 where cells failed and 130 on
    Ctrl-C; saved results stay for --resume.

    Args:
        cells: Cells, made by `morph.study.cell.cells_of` from a function and its cases.
        options: Parsed options, with those of `add_engine_options`.
        name: Name of the study.
    """
    results = _run_or_exit(cells, options, name)
    stale = sum(result.stale for result in results)
    if stale:
        sys.stderr.write(f"{stale} of {len(results)} rows are of other code than the present\n")
    bad = [result for result in results if result.status not in FINAL]
    for result in bad:
        sys.stderr.write(in_words(result) + "\n")
    if bad:
        sys.stderr.write(f"{len(bad)} of {len(results)} cells failed; --resume runs them again\n")
        sys.exit(STOPPED_SHORT)
    return results


def _run_or_exit(cells: Sequence[Cell], options: argparse.Namespace, name: str) -> list[Result]:
    try:
        with live() as watch:
            return run(
                [replace(cell, ignore=NO_PART_OF_A_ROW) for cell in cells],
                folder=options.out,
                name=name,
                options=EngineOptions(
                    engine=options.engine, workers=options.workers, scheduler=options.scheduler
                ),
                resume=options.resume,
                fresh=options.fresh,
                stale=options.stale,
                watch=watch,
            )
    except MorphError as error:
        sys.stderr.write(f"error: {error}\n")
        sys.exit(UNUSABLE)
    except KeyboardInterrupt:
        sys.stderr.write(f"interrupted; --resume goes on with what {options.out} holds\n")
        sys.exit(INTERRUPTED)


def rows_of(cells: Sequence[Cell], options: argparse.Namespace, *, name: str) -> list[JSON]:
    """Return the row of every cell, in their order; a refused cell's is `{"why": message}`.

    Rows of other code, kept by --stale keep, have `stale: true`. Arguments, and exit statuses
    where cells fail, are those of `results_of`.
    """
    rows = []
    for result in results_of(cells, options, name=name):
        error = result.error or {}
        row = result.row if result.status == "done" else {"why": error["what"]}
        rows.append({**row, "stale": True} if result.stale else row)
    return rows


def seeds_of(text: str) -> range:
    """Return the seeds of `first:end` (without `end`) or of a count: `5` is `0:5`.

    Raises:
        ValueError: The text is neither; argparse shows its own message.
    """
    first, _, last = text.rpartition(":")
    return range(int(first or 0), int(last))
