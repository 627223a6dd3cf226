"""Engines: `concurrent.futures` executors that report a worker's death and their own loss."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, Literal, ParamSpec, TypeVar, get_args

from morph.arrays import JSON
from morph.errors import StudyError

P = ParamSpec("P")
T = TypeVar("T")

EngineName = Literal["local", "dask", "slurm", "submitit-local", "inline"]
"""`local`: processes of this machine. `dask`: the workers of a scheduler, or of a cluster on
this machine. `slurm`: one job a cell. `submitit-local`: the same jobs on this machine, to test a
study. `inline`: one cell after another in this process, for a debugger; a crash ends the study."""

ENGINES: tuple[EngineName, ...] = get_args(EngineName)

MAX_WORKERS = 1024
"""Greatest number of workers of a study."""


class WorkerDied(Exception):
    """The process that ran a call ended before the call did."""


class Engine(Executor, ABC):
    """Executor whose futures raise `WorkerDied` where the worker ended before its call.

    A future raises `StudyError` where the engine itself is lost.
    """

    name: ClassVar[EngineName]
    shared: ClassVar[bool] = True
    """Whether a worker's death can end, or be attributed to, another call that runs at the same
    time; if so, a cell whose worker died is run again with no other beside it."""
    own_process: ClassVar[bool] = True
    """Whether calls run in worker processes, not in this one."""
    foreign: bool = False
    """Whether workers import a checkout of their own, which may be another version."""

    silent: float = 0.0
    """Seconds for which the engine has not answered; 0 while it does."""

    @abstractmethod
    def slots(self) -> int:
        """Return how many calls can run at once, at least 1.

        Raises:
            StudyError: The engine is lost: it can run no call any more.
        """

    @abstractmethod
    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Return the future of a call on a worker; the call must be picklable."""

    @abstractmethod
    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel the calls that still run or wait, and end the workers."""


@dataclass(frozen=True, kw_only=True)
class EngineOptions:
    """Choice of an engine and its settings, as on the command line."""

    engine: EngineName = "local"
    """Engine that runs the cells."""
    workers: int = 2
    """Processes, or jobs at once; ignored with `scheduler`, which has its own workers."""
    scheduler: str | None = None
    """Address of a Dask scheduler, such as tcp://host:8786."""
    job: dict[str, str | int] = field(default_factory=dict)
    """Parameters of a Slurm job under submitit's names: timeout_min, mem_gb, slurm_partition."""

    def __post_init__(self) -> None:
        if self.engine not in ENGINES:
            raise StudyError(
                f"there is no engine {self.engine!r}",
                where="--engine",
                fix=f"name one of {', '.join(ENGINES)}",
            )
        if not 1 <= self.workers <= MAX_WORKERS:
            raise StudyError(
                f"{self.workers} workers", where="--workers", fix=f"name 1 to {MAX_WORKERS}"
            )
        if self.scheduler is not None and self.engine != "dask":
            raise StudyError(
                f"engine {self.engine} has no scheduler",
                where="--scheduler",
                fix="add --engine dask, or leave it out",
            )
        if self.job and self.engine != "slurm":
            raise StudyError(
                f"engine {self.engine} asks for no jobs",
                where="--job",
                fix="add --engine slurm, or leave it out",
            )

    def as_json(self) -> JSON:
        """Return the entry `engine` of a study's manifest."""
        return {
            "name": self.engine,
            "workers": self.workers,
            "scheduler": self.scheduler,
            "job": self.job,
        }

    def start(self, folder: Path) -> Engine:
        """Return the engine, ready to run.

        Args:
            folder: Folder of the study; temporary files of an engine go below it.

        Raises:
            StudyError: A library is not installed, or the scheduler cannot be reached.
        """
        if self.engine == "dask":
            from morph.study.dask_engine import DaskEngine

            return DaskEngine(self.scheduler, workers=self.workers)
        if self.engine == "slurm":
            from morph.study.slurm import SlurmEngine

            return SlurmEngine(folder, workers=self.workers, job=self.job)
        if self.engine == "submitit-local":
            from morph.study.submitit_local import SubmititLocalEngine

            return SubmititLocalEngine(folder, workers=self.workers)
        if self.engine == "inline":
            from morph.study.inline import InlineEngine

            return InlineEngine()
        from morph.study.local import LocalEngine

        return LocalEngine(self.workers)
