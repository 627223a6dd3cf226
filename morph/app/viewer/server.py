"""The server of the viewer: a session for each person who opens the page."""

from __future__ import annotations

import logging
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from html import escape
from typing import Any

from morph.app.viewer.opening import Opening
from morph.app.viewer.serve import HOST, PORT, Door, open_door, quiet
from morph.app.viewer.session import Session
from morph.app.viewer.view import View

LOG = logging.getLogger(__name__)

MOST_PEOPLE = 20
"""People who look at one time; each has pictures sent 60 times a second."""


class Viewer:
    """A page that is served until it is closed.

    Args:
        views: Makes the views of a person who opens the page, in the order of the tabs.
        first: Number of the view to begin with.
        host: Address to serve at; any but loopback's takes a token.
        port: Port to serve at; if it is taken, the next free one.
        label: What the panel is called.
        opening: With what every page begins.

    Raises:
        OutputError: The page cannot be served.
    """

    def __init__(
        self,
        views: Callable[[], Sequence[View]],
        *,
        first: int = 0,
        host: str = HOST,
        port: int = PORT,
        label: str = "morph",
        opening: Opening | None = None,
    ) -> None:
        """Serve."""
        self._opening = opening
        self._views, self._first = views, first
        self._sessions: dict[int, Session] = {}
        self._lock, self._closed = threading.Lock(), False
        self.door: Door = open_door(host, port, label)
        self.door.server.on_client_connect(self._enters)
        self.door.server.on_client_disconnect(self._leaves)

    @property
    def address(self) -> str:
        """Where to look, with the token if it takes one."""
        return self.door.address

    @property
    def sessions(self) -> tuple[Session, ...]:
        """Those who look now."""
        with self._lock:
            return tuple(self._sessions.values())

    def wait(self, go_on: Callable[[], bool] = lambda: True) -> None:
        """Tell where to look, serve until the keyboard interrupts or the system asks to end, close.

        Nothing is lost by either, so both are a good end.

        Args:
            go_on: Is asked some times a second; False is an end, too.
        """
        try:
            with _ends_as_interrupted(), _faults_told():
                for note in self.door.notes:
                    sys.stderr.write(f"{note}\n")
                sys.stderr.write(f"see {self.address} (end with Ctrl-C)\n")
                sys.stderr.flush()
                while go_on():
                    time.sleep(0.1)
        except KeyboardInterrupt:
            sys.stderr.write("\n")
        finally:
            self.close()

    def close(self) -> None:
        """Stop serving."""
        with self._lock:
            self._closed = True
        sessions = self.sessions
        for session in sessions:
            session.close()
        for session in sessions:
            session.join(seconds=1.0)
        self.door.close()

    def _enters(self, client: Any) -> None:
        quiet(client)
        try:
            session = Session(client, self._views(), self._first, self._opening)
        except Exception as error:
            LOG.exception("no view could be made for a page")
            _only(client, f"The viewer itself failed ({type(error).__name__}: {error}).")
            return
        with self._lock:
            full = len(self._sessions) >= MOST_PEOPLE
            if not full and not self._closed:
                self._sessions[client.client_id] = session
        if full:
            _only(
                client,
                f"{MOST_PEOPLE} people look already, no more can: load the page again later.",
            )
        elif client.client_id in self.door.server.get_clients():
            session.start()
        else:
            # Gone before it was here: its leaving may have been heard of already.
            self._leaves(client)

    def _leaves(self, client: Any) -> None:
        with self._lock:
            session = self._sessions.pop(client.client_id, None)
        if session is not None:
            session.close()


def _only(client: Any, text: str) -> None:
    """Show a person nothing but a text."""
    client.gui.configure_theme(show_logo=False, show_share_button=False)
    client.gui.add_html(f'<p style="margin: 0.8em 1em">{escape(text)}</p>')


@contextmanager
def _ends_as_interrupted() -> Iterator[None]:
    """Have the system's wish to end be an interrupt; only Python's main thread hears of it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # A terminal that is closed hangs up; not every system knows of it.
    wishes = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]
    before = {wish: signal.signal(wish, signal.default_int_handler) for wish in wishes}
    try:
        yield
    finally:
        for wish, handler in before.items():
            # None stands for a handler that was not installed from Python.
            signal.signal(wish, signal.SIG_DFL if handler is None else handler)


@contextmanager
def _faults_told() -> Iterator[None]:
    """Tell the terminal what goes wrong in the viewer itself; nobody else listens there."""
    log, terminal = logging.getLogger("morph.app.viewer"), logging.StreamHandler(sys.stderr)
    log.addHandler(terminal)
    try:
        yield
    finally:
        log.removeHandler(terminal)
