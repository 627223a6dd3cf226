"""Run a subprocess with a timeout and kill all that it started."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

LOG_BYTES = 1_000_000
"""No more than this is read of what a program says."""

LOOK_S = 0.2
"""How often it is looked whether a program is to stop."""


@dataclass(frozen=True, kw_only=True)
class Ran:
    """How a program ended."""

    status: int | None
    """Its exit status, minus the number of the signal that ended it; None: it was killed."""
    said: str
    """What it wrote to its output and its error output."""


def attended(
    command: Sequence[str],
    *,
    folder: Path,
    environment: Mapping[str, str],
    timeout_s: float,
    stop: threading.Event | None = None,
) -> Ran:
    """Run a program to its end, or until its time is over, and return how it ended.

    It gets a process group of its own, all of which is killed at the end, whatever the end
    is: children that it left behind, too. What it says goes to a file, because a child that
    stays would hold a pipe open for ever.

    Args:
        command: The program and its arguments.
        folder: Where it runs; `said.log` is written there.
        environment: Its environment.
        timeout_s: Seconds that it may take.
        stop: Once this is set, by another thread, the program is killed.

    Raises:
        OSError: It cannot be started, or its folder cannot be written to.
    """
    log = folder / "said.log"
    with log.open("wb") as output:
        process = subprocess.Popen(
            command,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env=dict(environment),
            start_new_session=True,
        )
        try:
            status = _waited(process, time.monotonic() + timeout_s, stop or threading.Event())
        finally:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
    with log.open("rb") as read:
        return Ran(status=status, said=read.read(LOG_BYTES).decode("utf-8", "replace"))


def _waited(process: subprocess.Popen[bytes], end: float, stop: threading.Event) -> int | None:
    """Return the status of a process, or None if its time is over or it is to stop."""
    while not stop.is_set():
        left = end - time.monotonic()
        if left <= 0:
            return process.poll()
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.wait(timeout=min(left, LOOK_S))
    return None
