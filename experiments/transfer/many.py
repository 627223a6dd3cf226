"""Many cases of transfer on two processes, each line kept as soon as it is there."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from experiments.transfer.cases import ARMS, Case
from morph.arrays import JSON
from morph.errors import MorphError


@dataclass(frozen=True, kw_only=True)
class Job:
    """Who tries on which case."""

    case: Case
    """The case."""
    arm: str
    """Who."""
    seed: int
    """Of all chance."""
    trials: int
    """Most trials on the target."""

    @property
    def key(self) -> str:
        """What it is known by in a file."""
        return f"{self.case.name} | {self.case.spread} | {self.arm} | {self.seed} | {self.trials}"


def work(job: Job) -> JSON:
    """Return what came of one job; what cannot be done is a line that says why."""
    began = time.perf_counter()
    try:
        lines = ARMS[job.arm](job.case, job.seed, job.trials)
    except MorphError as error:
        lines = [{"why": str(error)}]
    return {
        "key": job.key,
        "case": job.case.name,
        "arm": job.arm,
        "seed": job.seed,
        "lines": lines,
        "seconds": time.perf_counter() - began,
    }


def done(jobs: Sequence[Job], *, kept: Path | None, processes: int) -> list[JSON]:
    """Return what came of all jobs, in their order; those in the file are not done again."""
    found = _before(kept)
    left = [job for job in jobs if job.key not in found]
    # One thread each: more would wait for each other.
    os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(max_workers=processes, mp_context=context) as pool:
        waiting = [pool.submit(work, job) for job in left]
        for count, each in enumerate(as_completed(waiting), start=1):
            line = each.result()
            found[line["key"]] = line
            if kept is not None:
                with kept.open("a") as file:
                    file.write(json.dumps(line) + "\n")
            print(f"{count}/{len(left)} {line['key']} {line['seconds']:.1f} s", file=sys.stderr)
    return [found[job.key] for job in jobs]


def _before(kept: Path | None) -> dict[str, JSON]:
    if kept is None or not kept.is_file():
        if kept is not None:
            kept.parent.mkdir(parents=True, exist_ok=True)
        return {}
    lines = [json.loads(line) for line in kept.read_text().splitlines() if line.endswith("}")]
    return {line["key"]: line for line in lines}
