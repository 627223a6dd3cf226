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
    from morph.app.cli.align_given import Side
    from morph.app.cli.stages import Stages
    from morph.app.report.align.outcome import Aligned

DONE, UNSAFE = 0, 3

SOURCE_SAMPLES = 200
"""Least transitions of the source: its simulation is at hand, and they cost nothing."""


def run_align(asked: Align) -> int:
    """Learn a map as asked and return the exit status.

    Raises:
        MorphError: An input cannot be used, or the result cannot be written.
        AlignError: No map can be learned from what was given.
    """
    from morph.app.cli.align_learn import check_map, learned
    from morph.app.cli.heartbeat import beating
    from morph.run_folder import lock_run_folder

    # Whatever the command line got wrong is told before any work is done.
    began = time.monotonic()
    _check_numbers(asked)
    check_map(asked.map)
    out = _out(asked)
    with nullcontext() if out is None else lock_run_folder(out):
        # What held it before may have left an alignment.
        _out(asked)
        with beating(asked.quiet) as told:
            source, target = _sides(asked, told)
            found = learned(asked, source, target, told, began=began, command=command(asked))
        if out is not None:
            _write(found, out, fresh=asked.fresh)
    _say(asked, found)
    return UNSAFE if found.guard.verdict == "unsafe" else DONE


def _check_numbers(asked: Align) -> None:
    from morph.app.cli.align_given import FEWEST, MOST

    if asked.samples < FEWEST:
        raise TransferError(
            f"{asked.samples} transitions tell nothing of a body",
            where="--samples",
            fix=f"give {FEWEST} or more",
        )
    if asked.samples > MOST:
        raise TransferError(
            f"{asked.samples} transitions would take longer than anyone waits",
            where="--samples",
            fix=f"give {MOST} or fewer; some hundreds tell all that there is",
        )
    if asked.seed < 0:
        raise TransferError(f"{asked.seed} is no seed", where="--seed", fix="give 0 or more")
    files = [each for each in (asked.source, asked.target) if each is not None]
    if len(asked.bodies) + len(files) != 2:
        raise TransferError(
            f"{len(asked.bodies)} bodies and {len(files)} files are named",
            where="morph align",
            fix="name two bodies, or one and a file of what the other did, or two files",
        )


def _out(asked: Align) -> Path | None:
    """Return the folder to write to, once it may be written to; None if there is none."""
    if asked.out is None:
        return None
    from morph.app.cli.outputs import ALIGN, check_out
    from morph.errors import OutputError

    out = check_out(asked.out, ALIGN)
    if (out / ALIGN.results[0]).is_file() and not asked.fresh:
        raise OutputError(
            "the folder holds an alignment already",
            where=asked.out,
            fix="name a new folder, or replace it by --fresh",
        )
    return out


def _sides(asked: Align, told: Stages) -> tuple[Side, Side]:
    """Return what both bodies did, made or read."""
    import numpy as np

    from morph.app.cli.align_given import made, read
    from morph.app.cli.transfer_bodies import body_of, check_task

    bodies, sides = list(asked.bodies), []
    if bodies:
        check_task(asked.task)
    for at, (file, option) in enumerate(((asked.source, "--source"), (asked.target, "--target"))):
        if file is not None:
            sides.append(read(file, option))
            continue
        name = bodies.pop(0)
        told.now(f"transitions of {name}")
        count = max(SOURCE_SAMPLES, asked.samples) if at == 0 else asked.samples
        rng = np.random.default_rng([asked.seed, at])
        sides.append(made(body_of(name, asked.task), count, rng))
    return sides[0], sides[1]


def _write(found: Aligned, out: Path, *, fresh: bool) -> None:
    from morph.app.cli.outputs import ALIGN, claim, clear
    from morph.app.report.align.files import write_align

    if fresh:
        clear(out, ALIGN, progress=True)
    claim(out, ALIGN, results=True)
    try:
        write_align(found, out)
    except BaseException:
        clear(out, ALIGN, progress=True)
        raise


def _say(asked: Align, found: Aligned) -> None:
    from morph.app.cli.align_said import lines
    from morph.app.cli.console import say

    if asked.json:
        sys.stdout.write(found.text())
        return
    say(lines(asked, found))


def command(asked: Align) -> str:
    """Return the command that gives this result again, wherever it is to be written."""
    import shlex

    parts = ["morph", "align", *asked.bodies]
    told: dict[str, object] = {
        "--source": asked.source, "--target": asked.target, "--pairs": asked.pairs,
        "--map": asked.map, "--task": asked.task, "--samples": asked.samples, "--seed": asked.seed,
    }  # fmt: skip
    for option, value in told.items():
        parts += [] if value is None else [option, str(value)]
    return shlex.join([*parts, *(() if asked.out is None else ("--out", "DIR"))])
