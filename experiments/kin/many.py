"""Many cases on few processes, each kept in a file as soon as it is there."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path

from morph.arrays import JSON
from morph.errors import MorphError

Case = tuple[int, int]
"""Seed and number of a target."""


def work(each: Callable[[int, int], list[JSON]], case: Case) -> JSON:
    """Return the lines of one case; what cannot be done is a line that says why."""
    began = time.perf_counter()
    try:
        lines = each(*case)
    except MorphError as error:
        lines = [{"why": str(error)}]
    return {"key": list(case), "lines": lines, "seconds": time.perf_counter() - began}


def done(
    each: Callable[[int, int], list[JSON]],
    cases: Sequence[Case],
    *,
    kept: Path | None,
    workers: int,
) -> list[JSON]:
    """Return the lines of all cases in their order; those in the file are not done again."""
    found = _before(kept)
    left = [case for case in cases if case not in found]
    # One thread each: more would wait for each other.
    os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    if workers < 2:
        for count, case in enumerate(left, start=1):
            _keep(found, work(each, case), kept, count, len(left))
    else:
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(max_workers=workers, mp_context=context) as pool:
            waiting = [pool.submit(work, each, case) for case in left]
            for count, ended in enumerate(as_completed(waiting), start=1):
                _keep(found, ended.result(), kept, count, len(left))
    return [line for case in cases for line in found[case]["lines"]]


def _keep(found: dict[Case, JSON], line: JSON, kept: Path | None, count: int, of: int) -> None:
    seed, number = line["key"]
    found[seed, number] = line
    if kept is not None:
        with kept.open("a") as file:
            file.write(json.dumps(line) + "\n")
    print(f"{count}/{of} body {seed}.{number} {line['seconds']:.1f} s", file=sys.stderr)


def _before(kept: Path | None) -> dict[Case, JSON]:
    if kept is None:
        return {}
    if not kept.is_file():
        kept.parent.mkdir(parents=True, exist_ok=True)
        return {}
    # A line that a kill cut short is done again.
    lines = [json.loads(line) for line in kept.read_text().splitlines() if line.endswith("}")]
    return {(line["key"][0], line["key"][1]): line for line in lines}


def seeds_of(text: str) -> range:
    """Return the seeds that `A:B` or a count names."""
    first, _, last = text.rpartition(":")
    return range(int(first or 0), int(last))
