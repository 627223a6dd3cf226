"""The server of the viewer: a session for each person who opens the page."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

from morph.app.viewer.door import HOST, PORT, Door, open_door
from morph.app.viewer.session import Session
from morph.app.viewer.view import View


class Viewer:
    """A page that is served until it is closed.

    Args:
        views: Makes the views of a person who opens the page, in the order of the tabs.
        first: Number of the view to begin with.
        host: Address to serve at; any but loopback's takes a token.
        port: Port to serve at; if it is taken, the next free one.

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
    ) -> None:
        """Serve."""
        self._views, self._first = views, first
        self._sessions: dict[int, Session] = {}
        self._lock = threading.Lock()
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

    def close(self) -> None:
        """Stop serving."""
        for session in self.sessions:
            session.close()
        self.door.close()

    def _enters(self, client: Any) -> None:
        session = Session(client, self._views(), self._first)
        with self._lock:
            self._sessions[client.client_id] = session
        session.start()

    def _leaves(self, client: Any) -> None:
        with self._lock:
            session = self._sessions.pop(client.client_id, None)
        if session is not None:
            session.close()
