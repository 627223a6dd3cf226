from __future__ import annotations

import socket

import pytest

from morph.app.viewer.binding import bound
from morph.errors import OutputError


def test_a_port_that_is_taken_leads_to_the_next_and_says_so() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        place = bound("127.0.0.1", port)
        place.socket.close()
    # Others may have taken those right behind it, but not a hundred.
    assert port < place.port < port + 100
    assert place.notes == (f"port {port} is taken; serving at {place.port} instead",)


def test_a_port_that_is_free_is_taken_as_asked_and_without_a_word() -> None:
    with socket.socket() as asked:
        asked.bind(("127.0.0.1", 0))
        port = asked.getsockname()[1]
    place = bound("127.0.0.1", port)
    place.socket.close()
    assert (place.port, place.notes) == (port, ())
    assert place.shown == f"localhost:{port}"


@pytest.mark.parametrize("port", [-1, 65536, 10**9])
def test_a_port_that_there_is_not_is_refused(port: int) -> None:
    with pytest.raises(OutputError, match=rf"there is no port {port}\b[\s\S]*0 to 65535"):
        bound("127.0.0.1", port)


@pytest.mark.parametrize("host", ["", "no-such-host.invalid", "a\0b", "ä" * 70, "a b", "1.2.3"])
def test_a_host_that_nobody_knows_is_refused(host: str) -> None:
    with pytest.raises(OutputError, match=r"no address is known|is no address of this machine"):
        bound(host, 0)


def test_an_address_of_another_machine_is_refused() -> None:
    # Of RFC 5737: given to nobody.
    with pytest.raises(OutputError, match=r"198\.51\.100\.7 is no address of this machine"):
        bound("198.51.100.7", 0)


@pytest.mark.parametrize(
    ("host", "is_open"), [("127.0.0.1", False), ("localhost", False), ("0.0.0.0", True)]
)
def test_only_loopback_is_closed_to_others(host: str, is_open: bool) -> None:
    place = bound(host, 0)
    place.socket.close()
    assert place.is_open == is_open
    # Anything may be asked by name only where a token is asked, too.
    assert (place.names == frozenset()) == is_open


def test_everywhere_is_shown_by_an_address_that_others_can_use() -> None:
    place = bound("0.0.0.0", 0)
    place.socket.close()
    assert not place.shown.startswith(("0.0.0.0", "127.", "localhost"))
    assert place.shown.endswith(f":{place.port}")
