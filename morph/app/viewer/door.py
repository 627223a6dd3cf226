"""The door to the viewer: where it is served, and who may come in."""

from __future__ import annotations

from contextlib import redirect_stdout
from dataclasses import dataclass
from io import StringIO
from typing import Any

from morph.errors import OutputError

HOST, PORT = "127.0.0.1", 8080
"""Where the page is served: to this machine only. A port that is taken leads to the next."""


@dataclass(frozen=True, kw_only=True)
class Door:
    """An open door."""

    server: Any
    """The `viser.ViserServer`."""
    address: str
    """Where to look."""

    def close(self) -> None:
        """Stop serving."""
        with redirect_stdout(StringIO()):
            self.server.stop()


def open_door(host: str, port: int, label: str) -> Door:
    """Return a server.

    Raises:
        OutputError: Nothing can be served there.
    """
    from viser import ViserServer

    try:
        # viser's greetings must not mix with what a command answers.
        with redirect_stdout(StringIO()):
            server = ViserServer(host=host, port=port, label=label, verbose=False)
    except OSError as error:
        raise OutputError(
            f"no page can be served: {error.strerror or error}",
            where=f"http://{host}:{port}",
            fix="name another --port",
        ) from error
    return Door(server=server, address=f"http://localhost:{server.get_port()}")
