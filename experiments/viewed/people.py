"""What stays behind of those who opened the viewer and left."""

from __future__ import annotations

import gc
import os
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from experiments.viewed.browser import page_of
from experiments.viewed.served import memory
from morph.app.viewer.server import Viewer
from morph.errors import ViewError

LOOKS = 0.5
"""How long each looks once something is shown, s."""

PATIENCE = 60.0
"""How long one waits for a page, or for its end, s."""


def opened_and_closed(viewer: Viewer, times: int, browser: Any = None) -> list[float]:
    """Return the memory of this process after each of many people came and left, MB (1e6 bytes).

    Args:
        viewer: A viewer that this process serves, which nobody looks at.
        times: How many come, one after another.
        browser: Playwright's browser, whose pages come; by default a socket that listens.

    Raises:
        ViewError: Somebody cannot come in, or does not get out again.
    """
    found = []
    for _ in range(times):
        with _came(viewer, browser):
            _until(lambda: any(each.content.actors for each in viewer.sessions), "nobody came in")
            time.sleep(LOOKS)
        _until(lambda: not viewer.sessions and not _working(), "somebody is not gone")
        # What only a collection frees is no leak.
        gc.collect()
        found.append(memory(os.getpid())[0])
    return found


def _came(viewer: Viewer, browser: Any) -> AbstractContextManager[Any]:
    return _listening(viewer.address) if browser is None else _looking(viewer.address, browser)


@contextmanager
def _looking(address: str, browser: Any) -> Iterator[None]:
    with page_of(browser) as page:
        page.goto(address)
        yield


@contextmanager
def _listening(address: str) -> Iterator[None]:
    from experiments.viewed.listener import entered

    with entered(address) as socket:
        over = threading.Event()
        reader = threading.Thread(target=_read, args=(socket, over))
        reader.start()
        try:
            yield
        finally:
            over.set()
            reader.join()


def _read(socket: Any, over: threading.Event) -> None:
    """Take what comes, as a page does; else the server would wait."""
    while not over.is_set():
        try:
            socket.recv(timeout=0.05)
        except TimeoutError:
            continue


def _working() -> bool:
    return any(thread.name == "morph-session" for thread in threading.enumerate())


def _until(holds: Callable[[], bool], otherwise: str) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > end:
            raise ViewError(
                otherwise, where="morph view", fix="look at what the viewer wrote to the terminal"
            )
        time.sleep(0.01)
