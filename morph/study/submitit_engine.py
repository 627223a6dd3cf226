"""Engines that submit each cell as a job through submitit."""

from __future__ import annotations

import shutil
import tempfile
import threading
from abc import abstractmethod
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, ClassVar, ParamSpec, TypeVar

from morph.errors import StudyError
from morph.extras import install_command
from morph.study.engine import Engine, WorkerDied

try:
    import submitit
    from submitit.core.utils import FailedSubmissionError, UncompletedJobError
except ImportError as error:
    raise StudyError(
        f"engine slurm needs a library that is not installed: {error}",
        where="--engine slurm",
        fix=install_command("cluster"),
    ) from error

P = ParamSpec("P")
T = TypeVar("T")

PREFIX = ".jobs."
"""First letters of the folder below the study's for submitit's files, its pickles and logs."""


class SubmititEngine(Engine):
    """Executor that runs every call as a submitit job, at most `workers` at once."""

    shared: ClassVar[bool] = False
    poll_interval: ClassVar[float]
    """Seconds between checks of a job."""
    remote: ClassVar[bool]
    """Whether jobs run on other machines, so that their files may appear after their end."""

    def __init__(self, folder: Path, *, workers: int) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        # A new folder of mode 0700, so that none of the user's is deleted in the end, and nobody
        # else writes into it: submitit's files are pickles, which execute code when loaded.
        self._folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=folder.absolute()))
        self._workers = workers
        self._threads = ThreadPoolExecutor(workers, thread_name_prefix="study")
        self._submitting = threading.Lock()
        self._ended = threading.Event()
        try:
            self._executor = self._start(self._folder)
        except BaseException:
            SubmititEngine.shutdown(self)
            raise

    @abstractmethod
    def _start(self, folder: Path) -> submitit.Executor:
        """Return submitit's executor, configured; its files go into `folder`."""

    def slots(self) -> int:
        """Return the number of jobs at once."""
        return self._workers

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Return the future of a call that runs as a job."""
        return self._threads.submit(self._run_job, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel the jobs and delete their files."""
        self._ended.set()
        self._threads.shutdown(wait=wait, cancel_futures=True)
        shutil.rmtree(self._folder, ignore_errors=True)

    def _run_job(self, fn: Callable[..., T], args: Any, kwargs: Any) -> T:
        try:
            with self._submitting:
                job = self._executor.submit(fn, *args, **kwargs)
        except (FailedSubmissionError, OSError) as error:
            raise StudyError(
                f"no job can be submitted: {' '.join(str(error).split())[:300]}",
                where=f"--engine {self.name}",
                fix="see that `sbatch` works here, then --resume: what had ended is kept",
            ) from error
        while not job.done():
            if self._ended.wait(self.poll_interval):
                self._cancel(job)
                raise WorkerDied("the study has ended")
        died = WorkerDied(f"job {job.job_id} ended without a result ({job.state})")
        if not self.remote and not job.paths.result_pickle.exists():
            raise died
        try:
            result: T = job.result()
        except UncompletedJobError:
            raise died from None
        return result

    def _cancel(self, job: Any) -> None:
        job.cancel()
