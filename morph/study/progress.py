"""Progress of a study: counts of cells and workers, rate and time left."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from morph.study.store import Result


@dataclass(kw_only=True)
class Progress:
    """Counts of cells and workers while a study runs; the scheduler updates them."""

    total: int
    """Cells of the study."""
    reused: int = 0
    """Cells whose results of an earlier run are used."""
    done: int = 0
    """Cells that ended in this run, with any status."""
    failed: int = 0
    """Cells of `done` that failed or were quarantined."""
    running: int = 0
    """Cells that run now."""
    worker_deaths: int = 0
    """Deaths of workers in this run."""
    silent: float = 0.0
    """Seconds for which the engine, such as a Dask scheduler, has not answered; 0 if it does."""
    start: float = field(default_factory=time.monotonic)
    """Start of this run on the monotonic clock, s."""

    @property
    def rate(self) -> float:
        """Cells ended a second in this run."""
        return self.done / max(time.monotonic() - self.start, 1e-9)

    @property
    def left(self) -> float | None:
        """Seconds until the end at this rate; None before the first cell of this run has ended."""
        remaining = self.total - self.reused - self.done
        if not remaining:
            return 0.0
        return remaining / self.rate if self.done else None


Watch = Callable[[Progress, Result | None], None]
"""Called with each result, and with None every half second in between."""


def ignore(progress: Progress, result: Result | None) -> None:
    """Show nothing."""
