"""Cases of a study, some at a time, each kept as soon as it is finished."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from morph.arrays import JSON

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""What libraries read to know how many threads they may start."""


def seeds_of(told: str) -> range:
    """Return seeds from `from:to`, the last not among them, or so many from 0 on."""
    first, _, last = told.rpartition(":")
    return range(int(first or 0), int(last))


def finished(
    cases: Sequence[Any],
    work: Callable[[Any], JSON],
    *,
    kept: Path | None = None,
    workers: int = 2,
) -> list[JSON]:
    """Return what every case shows, in their order; what stands in the file is not done again.

    Args:
        cases: Dataclasses of plain numbers and words, which name a case.
        work: What is done; a function of a module, for other processes to find.
        kept: A file of JSON lines, one for each finished case, added to as they finish.
        workers: How many processes; with 1 all is done in this one.
    """
    done = _read(kept)
    names = [json.dumps(asdict(case), sort_keys=True) for case in cases]
    left = [(name, case) for name, case in zip(names, cases, strict=True) if name not in done]
    began = time.monotonic()

    def keep(name: str, row: JSON) -> None:
        done[name] = row
        if kept:
            # Each on lines of its own: what a kill cut short stays alone.
            with kept.open("a") as file:
                file.write("\n" + json.dumps({"case": name, "row": row}) + "\n")
        count = sum(each in done for each in names)
        said = f"  {count} of {len(names)}, {time.monotonic() - began:.0f} s: {name}"
        print(said, file=sys.stderr, flush=True)

    if workers == 1 or len(left) < 2:
        for name, case in left:
            keep(name, work(case))
    else:
        # Threads of many processes on two cores wait for each other.
        os.environ.update(dict.fromkeys(THREADS, "1"))
        with multiprocessing.get_context("spawn").Pool(workers) as pool:
            for name, row in pool.imap_unordered(_Work(work), left):
                keep(name, row)
    return [done[name] for name in names]


class _Work:
    """A case's work under its name."""

    def __init__(self, work: Callable[[Any], JSON]) -> None:
        self.work = work

    def __call__(self, named: tuple[str, Any]) -> tuple[str, JSON]:
        name, case = named
        return name, self.work(case)


def _read(kept: Path | None) -> dict[str, JSON]:
    """Return what a file holds; a last line that a kill cut short is left out."""
    if kept is None or not kept.exists():
        return {}
    found: dict[str, JSON] = {}
    for line in filter(None, kept.read_text().splitlines()):
        try:
            one = json.loads(line)
        except json.JSONDecodeError:
            continue
        found[one["case"]] = one["row"]
    return found
