"""Where a page is served: a socket of our own, so that nobody else chooses the port."""

from __future__ import annotations

import errno
import ipaddress
import os
import socket
from dataclasses import dataclass

from morph.errors import OutputError

NEXT = 100
"""How many ports are tried, from the one that was asked for."""

LARGEST = 65535
"""The largest port there is."""

ELSEWHERE = ("203.0.113.1", 9)
"""An address that nobody has (RFC 5737); nothing is sent to it."""


@dataclass(frozen=True, kw_only=True)
class BoundSocket:
    """A place to serve at."""

    socket: socket.socket
    """It listens already."""
    address: str
    """The address that it listens at, in numbers."""
    port: int
    """Its port."""
    shown: str
    """What a browser is to ask for, `host:port`."""
    names: frozenset[str]
    """What those may call it who ask, without the port; empty for anything."""
    notes: tuple[str, ...] = ()
    """What is to be known of it, in words."""

    @property
    def is_open(self) -> bool:
        """Whether others than this machine can reach it."""
        return not ipaddress.ip_address(self.address).is_loopback


def bound(host: str, port: int) -> BoundSocket:
    """Return a place at a host, at the port or the next one that is free.

    Args:
        host: A name or an address of this machine.
        port: 0 for any that is free.

    Raises:
        OutputError: Nothing can be served there.
    """
    where = f"http://{host}:{port}"
    if not 0 <= port <= LARGEST:
        raise OutputError(
            f"there is no port {port}", where=where, fix=f"name a --port from 0 to {LARGEST}"
        )
    family, address = _found(host, where)
    for tried in range(port, min(port + NEXT, LARGEST + 1)):
        listening = _listening(family, address, tried, where)
        if listening is not None:
            return _place(listening, host, port)
    raise OutputError(
        f"port {port} and those that follow are all taken",
        where=where,
        fix="name another --port, or 0 for any that is free",
    )


def _found(host: str, where: str) -> tuple[socket.AddressFamily, str]:
    """Return the family and the address of a host; IPv4 comes first."""
    try:
        results = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM) if host else []
    except (OSError, ValueError):
        # A name that holds what no name may is a ValueError.
        results = []
    if not results:
        raise OutputError(
            f"no address is known by the name {host!r}",
            where=where,
            fix="name an address of this machine by --host, such as 127.0.0.1",
        )
    family, _, _, _, address = min(results, key=lambda each: each[0] != socket.AF_INET)
    return family, str(address[0])


def _listening(
    family: socket.AddressFamily, address: str, port: int, where: str
) -> socket.socket | None:
    """Return a socket that listens there; None if the port is taken."""
    listening = socket.socket(family, socket.SOCK_STREAM)
    try:
        if os.name == "posix":
            # A port that was served at a moment ago is free; elsewhere the option shares a port.
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if family == socket.AF_INET6:
            listening.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, address != "::")
        listening.bind((address, port))
        listening.listen(128)
    except OSError as error:
        listening.close()
        if error.errno == errno.EADDRINUSE:
            return None
        raise OutputError(
            _refused(error, address, port),
            where=where,
            fix="name an address of this machine by --host, and a --port from 1024 on",
        ) from error
    return listening


def _refused(error: OSError, address: str, port: int) -> str:
    if error.errno == errno.EADDRNOTAVAIL:
        return f"{address} is no address of this machine"
    if error.errno in (errno.EACCES, errno.EPERM):
        return f"port {port} is not for everybody to serve at"
    return f"no page can be served: {error.strerror or error}"


def _place(listening: socket.socket, host: str, requested: int) -> BoundSocket:
    address, port = listening.getsockname()[:2]
    taken = (
        (f"port {requested} is taken; serving at {port} instead",) if port != requested != 0 else ()
    )
    known = ipaddress.ip_address(address)
    if known.is_loopback:
        # Another port may lead here (`ssh -L`); another name may not: such a page is not ours.
        name = "localhost" if address == "127.0.0.1" else _bracketed(address)
        names = frozenset({"localhost", "127.0.0.1", "[::1]", _bracketed(address)})
    else:
        name, names = _bracketed(_reached() if known.is_unspecified else host), frozenset()
    return BoundSocket(
        socket=listening,
        address=address,
        port=port,
        shown=f"{name}:{port}",
        names=names,
        notes=taken,
    )


def _reached() -> str:
    """Return what others reach this machine by: its address on the way out, else its name."""
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out:
            # Connecting a datagram's socket only asks for the way; nothing is sent.
            out.connect(ELSEWHERE)
            return str(out.getsockname()[0])
    except OSError:
        return socket.gethostname()


def _bracketed(host: str) -> str:
    return f"[{host}]" if ":" in host else host
