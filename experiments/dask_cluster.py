"""A Dask scheduler and its workers on this machine, each a process of its own, over TCP."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from morph.errors import StudyError

START_TIMEOUT = 120.0
"""Seconds that a scheduler or its workers may take to start."""

LOCAL = ("--host", "127.0.0.1", "--no-dashboard")
NO_SETTINGS: Mapping[str, str] = {}


@dataclass(frozen=True, kw_only=True)
class DaskScheduler:
    """A running scheduler."""

    address: str
    """Address of the scheduler, such as tcp://127.0.0.1:8786."""
    process: subprocess.Popen[bytes]
    """Its process, of a session of its own."""


@contextmanager
def start_cluster(
    *, workers: int, settings: Mapping[str, str] = NO_SETTINGS
) -> Iterator[DaskScheduler]:
    """Yield a scheduler with workers of one thread each; nannies restart workers that die.

    Args:
        workers: Number of worker processes.
        settings: Environment variables for the scheduler, which configure Dask.

    Raises:
        StudyError: It does not start.
    """
    with start_scheduler(settings=settings) as scheduler, start_workers(scheduler.address, workers):
        yield scheduler


@contextmanager
def start_scheduler(*, settings: Mapping[str, str] = NO_SETTINGS) -> Iterator[DaskScheduler]:
    """Yield a scheduler without workers; arguments and errors as for `start_cluster`.

    Raises:
        StudyError: It does not start.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scheduler.json"
        options = (*LOCAL, "--port", "0", "--scheduler-file", str(file))
        with _process("scheduler", *options, settings=settings) as process:
            yield DaskScheduler(address=_address(file, process), process=process)


@contextmanager
def start_workers(address: str, count: int) -> Iterator[None]:
    """Run `count` workers of a scheduler for the duration of the context.

    Raises:
        TimeoutError: They do not start within `START_TIMEOUT`.
    """
    from distributed import Client

    with tempfile.TemporaryDirectory() as folder:
        options = ("--nthreads", "1", "--nworkers", str(count), "--local-directory", folder)
        with _process("worker", address, *LOCAL, *options):
            with Client(address) as client:
                client.wait_for_workers(count, timeout=START_TIMEOUT)
            yield


def worker_pids(address: str) -> list[int]:
    """Return the process ids of a scheduler's workers; empty if it does not answer."""
    from distributed import Client

    with suppress(Exception), Client(address, timeout=5.0) as client:
        # A worker that died meanwhile does not answer.
        return list(client.run(os.getpid, on_error="ignore").values())
    return []


@contextmanager
def _process(
    command: str, *arguments: str, settings: Mapping[str, str] = NO_SETTINGS
) -> Iterator[subprocess.Popen[bytes]]:
    """Yield a process of Dask's command line; it and its children are killed in the end."""
    process = subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{command}", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
        env={**os.environ, **settings},
    )
    try:
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _address(file: Path, process: subprocess.Popen[bytes]) -> str:
    end = time.monotonic() + START_TIMEOUT
    while time.monotonic() < end and process.poll() is None:
        with suppress(OSError, ValueError, KeyError):
            return str(json.loads(file.read_text())["address"])
        time.sleep(0.05)
    raise StudyError(
        "the Dask scheduler did not start",
        where="experiments.dask_cluster",
        fix="see what `dask scheduler` says here",
    )
