"""Engine of worker processes on this machine, one loky pool for each."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, ClassVar, ParamSpec, TypeVar

from loky import ProcessPoolExecutor

from morph.study.engine import Engine, EngineName, WorkerDied
from morph.study.worker import THREADS

P = ParamSpec("P")
T = TypeVar("T")


class LocalEngine(Engine):
    """Threads that each own a loky pool of one process.

    A pool of many processes breaks as a whole when one of them dies, and does not say which call
    that one ran. Here a death ends exactly one call, and it is known which.
    """

    name: ClassVar[EngineName] = "local"

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._threads = ThreadPoolExecutor(workers, thread_name_prefix="study")
        self._local = threading.local()
        self._pools: set[ProcessPoolExecutor] = set()
        self._lock = threading.Lock()
        self._closed = False

    def slots(self) -> int:
        """Return the number of worker processes."""
        return self._workers

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Return the future of a call in the next free process."""
        return self._threads.submit(self._run, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Kill the processes; calls that wait are cancelled."""
        with self._lock:
            self._closed = True
            pools = list(self._pools)
        self._threads.shutdown(wait=False, cancel_futures=True)
        for pool in pools:
            pool.shutdown(wait=False, kill_workers=True)
        self._threads.shutdown(wait=wait)

    def _run(self, fn: Callable[..., T], args: Any, kwargs: Any) -> T:
        try:
            future: Future[T] = self._submit(fn, args, kwargs)
            return future.result()
        except BrokenProcessPool as error:
            self._drop()
            raise WorkerDied(" ".join(str(error).split())) from None

    def _submit(self, fn: Callable[..., T], args: Any, kwargs: Any) -> Future[T]:
        try:
            future: Future[T] = self._pool().submit(fn, *args, **kwargs)
        except BrokenProcessPool:
            # The process died while it was idle: this call is not the cause.
            self._drop()
            future = self._pool().submit(fn, *args, **kwargs)
        return future

    def _pool(self) -> ProcessPoolExecutor:
        pool: ProcessPoolExecutor | None = getattr(self._local, "pool", None)
        if pool is None:
            with self._lock:
                if self._closed:
                    raise WorkerDied("the study has ended")
                pool = ProcessPoolExecutor(
                    max_workers=1,
                    initializer=_start_worker,
                    initargs=(os.getpid(),),
                    env=dict.fromkeys(THREADS, "1"),
                )
                self._pools.add(pool)
            self._local.pool = pool
        return pool

    def _drop(self) -> None:
        with self._lock:
            self._pools.discard(self._local.pool)
        self._local.pool.shutdown(wait=True, kill_workers=True)
        self._local.pool = None


def _start_worker(parent: int) -> None:
    """Ignore Ctrl-C, which the study handles, and end with the study even where it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_after, args=(parent,), daemon=True).start()


def _exit_after(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)
