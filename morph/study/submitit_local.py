"""Engine that runs submitit's jobs on this machine, to test a study before it goes to Slurm."""

from __future__ import annotations

import fcntl
import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, ParamSpec, TypeVar

from morph.study.engine import EngineName
from morph.study.submitit_engine import SubmititEngine

if TYPE_CHECKING:
    import submitit

P = ParamSpec("P")
T = TypeVar("T")

JOB_TIMEOUT_MIN = 1440
"""Minutes after which submitit ends a job: a day."""

WATCH_INTERVAL = 1.0
"""Seconds between a job's checks that its study still runs."""


class SubmititLocalEngine(SubmititEngine):
    """Processes of this machine that end with the study, even where it is killed.

    submitit's jobs outlive the program that submits them. These watch a file that the study
    holds locked; the operating system releases the lock when the study ends in any way.
    """

    name: ClassVar[EngineName] = "submitit-local"
    poll_interval: ClassVar[float] = 0.05
    remote: ClassVar[bool] = False

    def _start(self, folder: Path) -> submitit.Executor:
        import submitit

        handle, self._lock = tempfile.mkstemp(prefix="running.", dir=folder)
        self._lock_file = os.fdopen(handle)
        fcntl.flock(self._lock_file, fcntl.LOCK_EX)
        executor = submitit.LocalExecutor(folder=folder)
        executor.update_parameters(timeout_min=JOB_TIMEOUT_MIN)
        return executor

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Return the future of a call in a process of its own."""
        return super().submit(_run_attached, self._lock, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes and delete their files."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        self._lock_file.close()

    def _cancel(self, job: Any) -> None:
        job.cancel()
        # submitit's controller ends the process within two seconds, and then itself.
        while not job.done():
            time.sleep(self.poll_interval)


def _run_attached(lock: str, fn: Callable[..., T], args: Any, kwargs: Any) -> T:
    """Make a call in a process that ends with the study and on SIGTERM, which submitit ignores."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_exit_after, args=(lock,), daemon=True).start()
    return fn(*args, **kwargs)


def _exit_after(lock: str) -> None:
    while _is_locked(lock):
        time.sleep(WATCH_INTERVAL)
    os._exit(1)


def _is_locked(lock: str) -> bool:
    try:
        with open(lock) as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except FileNotFoundError:
        return False
    return False
