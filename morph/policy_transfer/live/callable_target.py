"""Live target from a Python function, or from reads and writes at a fixed rate."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from morph.arrays import JSON, Array
from morph.policy_transfer.live.connection import Connection, Heard
from morph.policy_transfer.live.protocol import Hello

Step = Callable[[Array | None], Mapping[str, float]]
"""From commands (nu,) to the reading at the end of the period: channels by name, and `t` if known.

None asks for a first reading, at rest where trials begin.
"""


class Called(Connection):
    """A function that is told commands, in the order of `hello.actuators`, and gives readings.

    It is called in a thread of its own, so that one that hangs cannot hold the watch up.

    Args:
        step: The function.
        hello: What it measures and can be told; `hello_for(robot, period)` if that is as the
            body has it. With the clock `target` each call must last one period.
        stopped: Called to stop the target and hold it safe, from another thread than `step`;
            a simulation has nothing to do there.
        name: How messages call it.
    """

    def __init__(
        self,
        step: Step,
        hello: Hello,
        *,
        stopped: Callable[[], object],
        name: str = "target of a function",
    ) -> None:
        self.name, self._step, self._hello, self._stopped = name, step, hello, stopped
        self._names = [each.name for each in hello.actuators]
        self._thread: threading.Thread | None = None

    def open(self, seconds: float) -> Hello:
        """Return what it was said to be."""
        if self._thread is None:
            self._open()
        return self._hello

    def _open(self) -> None:
        requested: queue.Queue[Array | bool | None] = queue.Queue()
        heard: queue.Queue[Heard] = queue.Queue()
        # A call that hangs keeps its own queues, and can never speak into a later trial.
        self._asked, self._heard = requested, heard
        self._thread = threading.Thread(target=self._work, args=(requested, heard), daemon=True)
        self._thread.start()

    def _work(self, requested: queue.Queue[Array | bool | None], heard: queue.Queue[Heard]) -> None:
        while not isinstance(command := requested.get(), bool):
            try:
                reading = dict(self._step(command))
            except Exception as error:
                raised = f"it raised {type(error).__name__}: {error}"
                heard.put(Heard(at=time.monotonic(), ended=raised[:500]))
                return
            time_said = reading.pop("t", None)
            document: JSON = {"state": {name: _plain(value) for name, value in reading.items()}}
            if time_said is not None:
                document["t"] = _plain(time_said)
            heard.put(Heard(at=time.monotonic(), said=document))

    def begin(self, message: Mapping[str, Any]) -> None:
        """Ask for the first reading."""
        self._asked.put(None)

    def tell(self, command: Mapping[str, float]) -> None:
        """Tell it commands."""
        self._asked.put(np.array([command[name] for name in self._names]))

    def hear(self, seconds: float) -> Heard | None:
        """Return its next reading."""
        try:
            return self._heard.get(timeout=seconds) if seconds > 0 else self._heard.get_nowait()
        except queue.Empty:
            return None

    def stop(self, seconds: float) -> bool:
        """Return whether `stopped` could be called, and came back in time."""
        done = threading.Event()
        threading.Thread(target=_call, args=(self._stopped, done), daemon=True).start()
        return done.wait(seconds)

    def close(self) -> None:
        """Let its thread end; the next trial makes a new one."""
        if self._thread is not None:
            self._asked.put(True)
            self._thread = None


class Paced:
    """What reads and what writes, as a `Step` that holds a fixed rate by a monotonic clock.

    Args:
        read: Returns a reading now: channels by name.
        write: Tells the actuators commands (nu,), now.
        period: Time from one reading to the next, s.
    """

    def __init__(
        self,
        read: Callable[[], Mapping[str, float]],
        write: Callable[[Array], object],
        period: float,
    ) -> None:
        self._read, self._write, self._period = read, write, period
        self._start, self._count = 0.0, 0
        self.overruns = 0
        """How many readings of the last run came late because a period was not long enough."""

    def __call__(self, command: Array | None) -> Mapping[str, float]:
        """Return the reading that is due next, once the command is told."""
        if command is None:
            self._start, self._count, self.overruns = time.monotonic(), 0, 0
        else:
            self._write(command)
            self._count += 1
            left = self._start + self._count * self._period - time.monotonic()
            if left > 0.0:
                time.sleep(left)
            else:
                self.overruns += 1
        now = time.monotonic() - self._start
        return {**self._read(), "t": now}


def _plain(value: object) -> float:
    """Return a number of NumPy's or Python's as a float; nan for anything else."""
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _call(what: Callable[[], object], done: threading.Event) -> None:
    # One that raises did not stop the target: it is not said to be done.
    try:
        what()
    except Exception:
        return
    done.set()
