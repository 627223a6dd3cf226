"""`morph align`: how a body's states and commands are another's, and which part is which."""

from __future__ import annotations

import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from morph.app.cli.align_arguments import Align
from morph.errors import TransferError

if TYPE_CHECKING:
    from morph.app.cli.align_inputs import Side
    from morph.app.cli.stages import Stages
    from morph.app.report.align.outcome import Aligned

DONE, UNSAFE = 0, 3

SOURCE_SAMPLES = 200
"""Least transitions of the source: its simulation is at hand, and they cost nothing."""


def run_align(options: Align) -> int:
    """Learn a map as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used, or the result cannot be written.
        AlignError: No map can be learned from what was given.
    """
    result = aligned(options)
    _say(options, result)
    return UNSAFE if result.guard.verdict == "unsafe" else DONE


def aligned(options: Align) -> Aligned:
    """Learn a map, write it where a folder is named, and return it.

    Raises:
        MorphError: An input cannot be used, or the result cannot be written.
        AlignError: No map can be learned from what was given.
    """
    from morph.app.cli.align_learn import check_map, learned
    from morph.app.cli.heartbeat import beating
    from morph.run_folder import lock_run_folder

    # Whatever the command line got wrong is told before any work is done.
    began = time.monotonic()
    _check_numbers(options)
    check_map(options.map)
    out = _out(options)
    with nullcontext() if out is None else lock_run_folder(out):
        # What held it before may have left an alignment.
        _out(options)
        with beating(options.quiet) as progress:
            source, target = _sides(options, progress)
            result = learned(
                options, source, target, progress, began=began, command=command(options)
            )
        if out is not None:
            _write(result, out, fresh=options.fresh)
    return result


def _check_numbers(options: Align) -> None:
    from morph.app.cli.align_inputs import FEWEST, MOST

    if options.samples < FEWEST:
        raise TransferError(
            f"{options.samples} transitions tell nothing of a body",
            where="--samples",
            fix=f"give {FEWEST} or more",
        )
    if options.samples > MOST:
        raise TransferError(
            f"{options.samples} transitions would take longer than anyone waits",
            where="--samples",
            fix=f"give {MOST} or fewer; some hundreds tell all that there is",
        )
    if options.seed < 0:
        raise TransferError(f"{options.seed} is no seed", where="--seed", fix="give 0 or more")
    files = [each for each in (options.source, options.target) if each is not None]
    if len(options.bodies) + len(files) != 2:
        raise TransferError(
            f"{len(options.bodies)} bodies and {len(files)} files are named",
            where="morph align",
            fix="name two bodies, or one and a file of what the other did, or two files",
        )


def _out(options: Align) -> Path | None:
    """Return the folder to write to, once it may be written to; None if there is none."""
    if options.out is None:
        return None
    from morph.app.cli.outputs import ALIGN, check_out
    from morph.errors import OutputError

    out = check_out(options.out, ALIGN)
    if (out / ALIGN.results[0]).is_file() and not options.fresh:
        raise OutputError(
            "the folder holds an alignment already",
            where=options.out,
            fix="name a new folder, or replace it by --fresh",
        )
    return out


def _sides(options: Align, progress: Stages) -> tuple[Side, Side]:
    """Return what both bodies did, made or read."""
    import numpy as np

    from morph.app.cli.align_inputs import made, read
    from morph.app.cli.transfer_bodies import body_of, check_task

    bodies, sides = list(options.bodies), []
    if bodies:
        check_task(options.task)
    for at, (file, option) in enumerate(
        ((options.source, "--source"), (options.target, "--target"))
    ):
        if file is not None:
            sides.append(read(file, option))
            continue
        name = bodies.pop(0)
        progress.now(f"transitions of {name}")
        count = max(SOURCE_SAMPLES, options.samples) if at == 0 else options.samples
        rng = np.random.default_rng([options.seed, at])
        sides.append(made(body_of(name, options.task), count, rng))
    return sides[0], sides[1]


def _write(result: Aligned, out: Path, *, fresh: bool) -> None:
    from morph.app.cli.outputs import ALIGN, claim, clear
    from morph.app.report.align.files import write_align

    if fresh:
        clear(out, ALIGN, progress=True)
    claim(out, ALIGN, results=True)
    try:
        write_align(result, out)
    except BaseException:
        clear(out, ALIGN, progress=True)
        raise


def _say(options: Align, result: Aligned) -> None:
    from morph.app.cli.align_text import lines
    from morph.app.cli.console import say

    if options.json:
        sys.stdout.write(result.text())
        return
    say(lines(options, result))


def command(options: Align) -> str:
    """Return the command that gives this result again, wherever it is to be written."""
    import shlex

    parts = ["morph", "align", *options.bodies]
    known: dict[str, object] = {
        "--source": options.source, "--target": options.target, "--pairs": options.pairs,
        "--map": options.map, "--task": options.task, "--samples": options.samples,
        "--seed": options.seed,
    }  # fmt: skip
    for option, value in known.items():
        parts += [] if value is None else [option, str(value)]
    return shlex.join([*parts, *(() if options.out is None else ("--out", "DIR"))])
