"""`morph study`: run the cells of a file, keep each result, compare two runs."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from morph.app.cli.console import harmless, say
from morph.app.cli.study_arguments import Study
from morph.errors import StudyError
from morph.regular_file import read_regular
from morph.study.cell import check_function
from morph.study.compare import RowDifference, StudyComparison, compare
from morph.study.encoding import encode_row
from morph.study.engine import EngineOptions
from morph.study.file import load_study
from morph.study.live import in_words, live
from morph.study.manifest import ROWS, identities
from morph.study.run import run
from morph.study.store import FINAL, MAX_BYTES, Result, count

DONE, STOPPED_SHORT, INTERRUPTED = 0, 3, 130

SHOWN = 20
"""Cells that are listed one by one; JSON has all."""


def run_study(arguments: Study) -> int:
    """Run a study's cells, write its rows, and return the exit status.

    Raises:
        StudyError: The file, the folder or the engine cannot be used.
        OutputError: A result cannot be written.
    """
    study = load_study(arguments.file)
    options = EngineOptions(
        engine=arguments.engine,
        workers=arguments.workers,
        scheduler=arguments.scheduler,
        job=_job(arguments.job),
    )
    out = _out(arguments, study.name)
    sys.path[:0] = [str(folder) for folder in study.path]
    # Before the cells are made: there may be many.
    check_function(study.function)
    try:
        with live(quiet=arguments.quiet) as watch:
            results = run(
                study.cells,
                folder=out,
                name=study.name,
                options=options,
                resume=arguments.resume,
                fresh=arguments.fresh,
                stale=arguments.stale,
                watch=watch,
            )
    except KeyboardInterrupt:
        saved = count(out)
        sys.stderr.write(f"interrupted; {saved} results are saved in {out}: go on with --resume\n")
        return INTERRUPTED
    as_before = True
    if arguments.against:
        as_before = _compare(out, arguments.against, arguments)
    elif arguments.json:
        sys.stdout.write(read_regular(out / ROWS, MAX_BYTES).decode())
    else:
        _say_results(results, out)
    return DONE if as_before and all(each.status in FINAL for each in results) else STOPPED_SHORT


def _out(options: Study, name: str) -> Path:
    """Return the folder of the results; what it is compared with is looked at before any work."""
    if options.out == "":
        raise StudyError("--out is empty", where="--out", fix="name a folder")
    out = Path(options.out) if options.out else Path("out") / name
    if options.against:
        identities(options.against)
        if out.resolve() == options.against.resolve():
            raise StudyError(
                f"{out} would be compared with itself",
                where="--against",
                fix="name the folder of another run, or another --out",
            )
    return out


def _job(options: Sequence[str]) -> dict[str, str | int]:
    pairs = [each.partition("=") for each in options]
    for option, (name, equals, _) in zip(options, pairs, strict=True):
        if not (name.isidentifier() and equals):
            raise StudyError(
                f"--job must be NAME=VALUE, got {option!r}",
                where="--job",
                fix="write, for example, --job timeout_min=60",
            )
    return {name: int(value) if value.isdecimal() else value for name, _, value in pairs}


def _say_results(results: Sequence[Result], out: Path) -> None:
    counts = Counter(each.status for each in results)
    lines = [f"{len(results)} cells: {', '.join(f'{n} {status}' for status, n in counts.items())}"]
    stale = sum(each.stale for each in results)
    if stale:
        lines.append(f"{stale} rows were made by other code and are marked stale")
    lines += _listed([in_words(each) for each in results if each.status != "done"])
    lines.append(f"rows: {out / ROWS}")
    say((harmless(line), "") for line in lines)


def _compare(out: Path, against: Path, options: Study) -> bool:
    """Say how the rows differ from another run's, and return whether they are equal."""
    comparison = compare(out, against, without=frozenset(options.ignore))
    if options.json:
        sys.stdout.write(json.dumps(encode_row(comparison), indent=1) + "\n")
    else:
        _say_comparison(comparison)
    return comparison.equal


def _say_comparison(comparison: StudyComparison) -> None:
    different = [
        f"{words}: {each.entry} {_difference(each)}"
        for words, differences in comparison.different
        for each in differences
    ]
    lines = [
        f"{comparison.same} cells the same, {len(comparison.different)} different, "
        f"{len(comparison.missing_first)} missing in this run, "
        f"{len(comparison.missing_second)} in --against",
        *_listed(different),
        *_listed([f"missing in this run: {words}" for words in comparison.missing_first]),
        *_listed([f"missing in --against: {words}" for words in comparison.missing_second]),
    ]
    say((harmless(line), "") for line in lines)


def _difference(each: RowDifference) -> str:
    if each.only == "first":
        return f"{each.first!r} in this run only"
    if each.only == "second":
        return f"{each.second!r} in --against only"
    apart = "" if each.by is None else f", {each.by:.3g} apart"
    return f"{each.first!r} and {each.second!r}{apart}"


def _listed(lines: Sequence[str]) -> list[str]:
    more = [f"and {len(lines) - SHOWN} more"] if len(lines) > SHOWN else []
    return [f"  {line}" for line in [*lines[:SHOWN], *more]]
