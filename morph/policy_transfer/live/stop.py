"""The stop button of a live target: a function, a file, Ctrl-C, or the signal to end."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)
"""What presses the button from outside: Ctrl-C, and what a system ends a program with."""


class Stop:
    """A button that ends the trial that is under way; the target is told to stop.

    Args:
        button: A function that says whether it is pressed, asked every few milliseconds, or a
            file that presses it by being there; None for signals alone.
    """

    def __init__(self, button: Callable[[], bool] | Path | None = None) -> None:
        self._button = button
        self._caught: int | None = None

    def pressed(self) -> str | None:
        """Return what pressed the button, in words; None if nothing did."""
        if self._caught is not None:
            return f"by the signal {signal.Signals(self._caught).name}"
        if isinstance(self._button, Path):
            return f"by the file {self._button}" if self._button.exists() else None
        if self._button is not None and self._button():
            return "by its button"
        return None

    @contextmanager
    def armed(self) -> Iterator[None]:
        """Catch the signals until the end of the block, and forget those of earlier ones.

        Only Python's main thread can catch signals; elsewhere the button alone counts.
        """
        self._caught = None
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = {number: signal.signal(number, self._catch) for number in SIGNALS}
        try:
            yield
        finally:
            for number, handler in before.items():
                # None stands for a handler that was not installed from Python.
                signal.signal(number, signal.SIG_DFL if handler is None else handler)

    def _catch(self, number: int, frame: FrameType | None) -> None:
        self._caught = number
