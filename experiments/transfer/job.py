"""Who tries on which case of transfer, and what comes of it."""

from __future__ import annotations

import time
from dataclasses import dataclass

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
