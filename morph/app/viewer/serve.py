"""Serve the viewer: address, port and access."""

from __future__ import annotations

import atexit
import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from dataclasses import dataclass
from io import StringIO
from secrets import token_urlsafe
from typing import Any

from morph.app.viewer.auth import RequestGuard
from morph.app.viewer.binding import BoundSocket, bound
from morph.app.viewer.front_page import front_page
from morph.errors import OutputError

HOST, PORT = "127.0.0.1", 8080
"""Where the page is served: to this machine only. A port that is taken leads to the next."""

LARGEST_MESSAGE = 4 * 2**20
"""Of what a page says to us, bytes; a picture of a page that we asked for is such a message."""

VISER = "viser.infra._infra"
"""The module whose server is guarded."""

LOG = logging.getLogger("morph.websockets")
"""What pages get wrong is told here, to nobody unless somebody listens."""

_ONE_AT_A_TIME = threading.Lock()


@dataclass(frozen=True, kw_only=True)
class Door:
    """An open door."""

    server: Any
    """The `viser.ViserServer`."""
    address: str
    """Where to look, with the token if it takes one."""
    is_open: bool = False
    """Whether others than this machine can come in, by a token."""
    notes: tuple[str, ...] = ()
    """What is to be known of it, a sentence each."""

    def close(self) -> None:
        """Stop serving."""
        with redirect_stdout(StringIO()):
            self.server.stop()


def open_door(host: str, port: int, label: str) -> Door:
    """Return a server that answers only to whom it should.

    Args:
        host: A name or an address of this machine; whatever is not loopback takes a token.
        port: If it is taken, the next one that is free is used; 0 for any.
        label: What its panel is called.

    Raises:
        OutputError: Nothing can be served there.
    """
    place = bound(host, port)
    token = token_urlsafe(24) if place.is_open else None
    try:
        server = _served(place, token, label)
    except BaseException:
        place.socket.close()
        raise
    quiet(server)
    # Where nothing closes it, it ends with the program and without a word on the output.
    atexit.unregister(server.stop)
    atexit.unregister(server._websock_server.stop)
    address, notes = f"http://{place.shown}", place.notes
    if token is not None:
        address = f"{address}/?token={token}"
        notes = (
            *notes,
            "this page is open to the network, without encryption: who has the address can look, "
            "have this machine compute, and save bodies on its shelf",
        )
    return Door(server=server, address=address, is_open=place.is_open, notes=notes)


def quiet(speaker: Any) -> None:
    """Have a server, or a client of it, do nothing for pages but what the viewer needs.

    viser would let any page have the server opened to the whole world by a tunnel, or send it
    files of any size.

    Args:
        speaker: A `viser.ViserServer`, or a `viser.ClientHandle`.
    """
    from viser import ViserServer, _messages

    refused: list[Any] = [_messages.FileTransferStartUpload, _messages.FileTransferPart]
    handler = speaker.gui._websock_interface
    if isinstance(speaker, ViserServer):
        refused += [_messages.ShareUrlRequest, _messages.ShareUrlDisconnect]
    for message in refused:
        with suppress(AssertionError):
            handler.unregister_handler(message)
    # What is said to a page between its end and our hearing of it is not worth a warning.
    handler.get_message_buffer()._sanctioned_dead_writes += 1


def _served(place: BoundSocket, token: str | None, label: str) -> Any:
    import viser

    LOG.addFilter(_matters)
    people = [0]
    guard = RequestGuard(
        place,
        token,
        front_page(),
        protocol=f"viser-v{viser.__version__}",
        people=lambda: people[0],
    )
    # viser's greetings must not mix with what a command answers.
    with _guarded(place, guard, people) as used, redirect_stdout(StringIO()):
        # Were our own socket not used, it would serve to this machine only, until we notice.
        server = viser.ViserServer(host="127.0.0.1", port=place.port, label=label, verbose=False)
        if not used or server.get_port() != place.port:
            server.stop()
            raise OutputError(
                f"viser {viser.__version__} serves in a way that is not guarded here",
                where=f"http://{place.shown}",
                fix="install the viser that pyproject.toml names",
            )
    return server


@contextmanager
def _guarded(place: BoundSocket, guard: RequestGuard, people: list[int]) -> Iterator[list[bool]]:
    """Have viser serve at our socket and ask our guard; what is given back says if it did."""
    from websockets.asyncio import server as websockets

    serve, used = websockets.serve, list[bool]()

    def ours(handler: Any, *where: Any, **how: Any) -> Any:
        if handler.__module__ != VISER:
            return serve(handler, *where, **how)
        used.append(True)

        async def counted(connection: Any) -> None:
            people[0] += 1
            try:
                await handler(connection)
            finally:
                people[0] -= 1

        how |= {"process_request": guard.answer, "max_size": LARGEST_MESSAGE, "logger": LOG}
        return serve(counted, sock=place.socket, **how)

    with _ONE_AT_A_TIME:
        websockets.serve = ours  # type: ignore[assignment,misc]
        try:
            yield used
        finally:
            websockets.serve = serve  # type: ignore[misc]


def _matters(record: logging.LogRecord) -> bool:
    """Return whether a record is more than that somebody came and did not ask for a page.

    Browsers open connections in advance, and networks are full of strangers.
    """
    return record.getMessage() != "opening handshake failed"
