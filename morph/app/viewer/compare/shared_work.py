"""Long computations shared by all sessions, each done once in a thread."""

from __future__ import annotations

import atexit
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from morph.errors import MorphError, ViewError

Found = TypeVar("Found")

OFTEN = 0.25
"""Progress is told at most every so many seconds."""

PATIENCE = 3.0
"""How long the end of the program waits for work to stop, s."""


class Work(Generic[Found]):
    """Something that is computed once, for everybody who looks.

    Any thread may ask how it stands; those who listen are called by the thread that works.
    """

    def __init__(self) -> None:
        """Begin with nothing found."""
        self.told = ""
        """How far it is, in words."""
        self.found: Found | None = None
        """What came of it, once it is done and did not fail."""
        self.error: MorphError | None = None
        """Why nothing came of it."""
        self._done = threading.Event()
        self._lock = threading.Lock()
        self._listeners: list[Callable[[], None]] = []
        self._said = 0.0

    @property
    def done(self) -> bool:
        """Whether it has ended, well or not."""
        return self._done.is_set()

    def wait(self, seconds: float | None = None) -> bool:
        """Return whether it is done, once it is or so many seconds have passed."""
        return self._done.wait(seconds)

    def listen(self, listener: Callable[[], None]) -> None:
        """Have something called whenever this gets on, and when it is done; not afterwards."""
        with self._lock:
            if not self.done:
                self._listeners.append(listener)

    def tell(self, text: str) -> None:
        """Say how far it is; those who listen hear of it some times a second."""
        self.told = text
        if (now := time.monotonic()) - self._said >= OFTEN:
            self._said = now
            self._call(self._listeners)

    def end(self, result: Found | None, error: MorphError | None) -> None:
        """Say what came of it."""
        with self._lock:
            self.found, self.error = result, error
            self._done.set()
            listeners, self._listeners = self._listeners, []
        self._call(listeners)

    def _call(self, listeners: list[Callable[[], None]]) -> None:
        for listener in tuple(listeners):
            listener()


@dataclass(frozen=True, kw_only=True)
class Longer(Generic[Found]):
    """What quick work gives back if what is left of it takes long."""

    job: Callable[[Work[Found]], Found]
    """The rest of it."""


Job = Callable[[Work[Found]], "Found | Longer[Found]"]
"""What finds something, and may `tell` how far it is."""


class Crew:
    """Two threads: what takes long never holds up what is quick."""

    def __init__(self) -> None:
        """Hire them; they begin when there is something to do."""
        self._over = threading.Event()
        self._queues: tuple[queue.SimpleQueue[Callable[[], None]], ...] = (
            queue.SimpleQueue(),
            queue.SimpleQueue(),
        )
        self._threads: list[threading.Thread] = []
        self._lock = threading.Lock()

    def ask(self, job: Job[Found]) -> Work[Found]:
        """Have something found, and return where it will be."""
        work: Work[Found] = Work()
        self._begin()
        self._queues[0].put(lambda: self._do(work, job))
        return work

    def check(self) -> None:
        """Let long work ask whether the program ends.

        Raises:
            ViewError: It does.
        """
        if self._over.is_set():
            raise ViewError("the viewer is being closed", where="morph view", fix="open it again")

    def close(self) -> None:
        """Stop; work that is under way has some seconds to notice."""
        self._over.set()
        for each in self._queues:
            each.put(lambda: None)
        for thread in self._threads:
            thread.join(PATIENCE)

    def _begin(self) -> None:
        with self._lock:
            if self._threads or self._over.is_set():
                return
            # Python ends badly under a thread that is deep in a library.
            atexit.register(self.close)
            for each in self._queues:
                thread = threading.Thread(
                    target=self._run, args=(each,), name="morph-crew", daemon=True
                )
                self._threads.append(thread)
                thread.start()

    def _run(self, requested: queue.SimpleQueue[Callable[[], None]]) -> None:
        while not self._over.is_set():
            requested.get()()

    def _do(self, work: Work[Found], job: Job[Found]) -> None:
        try:
            self.check()
            result = job(work)
        except MorphError as error:
            work.end(None, error)
            return
        if isinstance(result, Longer):
            rest = result.job
            self._queues[1].put(lambda: self._do(work, rest))
        else:
            work.end(result, None)
