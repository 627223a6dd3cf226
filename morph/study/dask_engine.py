"""Engine on the workers of a Dask scheduler, on this machine or on many."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import ExitStack, suppress
from typing import Any, ClassVar, ParamSpec, TypeVar

from morph.errors import StudyError
from morph.extras import install_command
from morph.study.engine import Engine, EngineName, WorkerDied

try:
    import dask.config
    from distributed import Client, KilledWorker, LocalCluster
    from distributed.utils import silence_logging_cmgr
except ImportError as error:
    raise StudyError(
        f"engine dask needs a library that is not installed: {error}",
        where="--engine dask",
        fix=install_command("cluster"),
    ) from error

P = ParamSpec("P")
T = TypeVar("T")

CONNECT_TIMEOUT = 10.0
"""Seconds that a scheduler may take to answer."""

EMPTY_TIMEOUT = 60.0
"""Seconds that a scheduler may be without workers: a nanny restarts one within a few."""

ANSWER_TIMEOUT = 10.0
"""Seconds after which a scheduler that does not answer is reported."""

LOST_TIMEOUT = 60.0
"""Seconds without an answer after which the scheduler counts as lost."""

POLL_INTERVAL = 1.0
"""Seconds between requests for the number of workers."""


class DaskEngine(Engine):
    """`concurrent.futures` executor of a Dask scheduler.

    A scheduler reruns the call of a dead worker on others, up to its `allowed-failures` (3 by
    default); only then does the future raise `WorkerDied`.
    """

    name: ClassVar[EngineName] = "dask"

    def __init__(self, address: str | None, *, workers: int) -> None:
        self._address, self._cluster = address, None
        # The study's own error replaces Dask's log of a lost scheduler.
        self._quiet = ExitStack()
        self._quiet.enter_context(silence_logging_cmgr(logging.CRITICAL))
        self._threads, self._last_look = 0, 0.0
        self._last_workers = self._last_answer = time.monotonic()
        if address is None:
            # Report a dead worker at once: the study itself runs the call again, alone.
            config = {"distributed.scheduler.allowed-failures": 0}
            with dask.config.set(config):
                self._cluster = LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=None,
                    silence_logs=logging.CRITICAL,
                )
        else:
            self.foreign = True
        try:
            self._client = Client(self._cluster or address, timeout=CONNECT_TIMEOUT)
        except (OSError, ValueError) as error:
            self._quiet.close()
            raise StudyError(
                f"no Dask scheduler can be reached: {' '.join(str(error).split())[:200]}",
                where=f"--scheduler {address}",
                fix="start `dask scheduler` there, or correct the address: tcp://host:8786",
            ) from error
        self._executor = self._client.get_executor(pure=False)

    def slots(self) -> int:
        """Return the number of threads of all workers; 1 while workers may yet come.

        Raises:
            StudyError: The scheduler is lost, or has had no workers for `EMPTY_TIMEOUT`.
        """
        if time.monotonic() - self._last_look > POLL_INTERVAL:
            self._poll()
        if self._threads:
            self._last_workers = self._last_look
        elif self._last_look - self._last_workers > EMPTY_TIMEOUT:
            raise StudyError(
                f"the scheduler has had no workers for {EMPTY_TIMEOUT:.0f} s",
                where=f"--scheduler {self._address}",
                fix="start `dask worker ADDRESS` with a nanny, then --resume",
            )
        return max(1, self._threads)

    def _poll(self) -> None:
        """Ask for the number of threads; note for how long there has been no answer."""
        try:
            threads = self._client.nthreads(callback_timeout=ANSWER_TIMEOUT)
            self._threads, self._last_answer = sum(threads.values()), time.monotonic()
        except TimeoutError as error:
            if time.monotonic() - self._last_answer > LOST_TIMEOUT:
                raise self._lost(f"no answer for {LOST_TIMEOUT:.0f} s") from error
        except Exception as error:  # Tornado, asyncio and distributed each have their own.
            raise self._lost(error) from error
        self._last_look = time.monotonic()
        silent = self._last_look - self._last_answer
        self.silent = silent if silent > ANSWER_TIMEOUT else 0.0

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Return the future of a call on any worker."""
        outer: Future[T] = Future()
        try:
            inner = self._executor.submit(fn, *args, **kwargs)
        except Exception as error:  # A client without scheduler raises errors of many classes.
            outer.set_exception(self._lost(error))
            return outer
        inner.add_done_callback(lambda ended: self._copy(ended, outer))
        return outer

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Cancel the calls, and end the cluster of this machine if the engine started it."""
        # A lost scheduler runs nothing that could be cancelled.
        with suppress(Exception):
            self._executor.shutdown(wait=False)
            self._client.close(timeout=CONNECT_TIMEOUT)
        if self._cluster is not None:
            self._cluster.close(timeout=CONNECT_TIMEOUT)
        self._quiet.close()

    def _copy(self, inner: Future[Any], outer: Future[Any]) -> None:
        if inner.cancelled():
            outer.set_exception(self._lost("it cancelled the call"))
            return
        error = inner.exception()
        if isinstance(error, KilledWorker):
            outer.set_exception(WorkerDied(f"on worker {error.last_worker.address}"))
        elif error is not None:
            outer.set_exception(error)
        else:
            outer.set_result(inner.result())

    def _lost(self, why: object) -> StudyError:
        text = " ".join(str(why).split())[:200] or type(why).__name__
        return StudyError(
            f"the Dask scheduler is gone: {text}",
            where=f"--scheduler {self._address}" if self._address else "--engine dask",
            fix="start it again, then go on with --resume: what had ended is kept",
        )
