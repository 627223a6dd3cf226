from __future__ import annotations

import gzip
import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from morph.app.viewer.binding import bound
from morph.app.viewer.serve import Door, open_door
from morph.app.viewer.server import Viewer
from morph.app.viewer.view import View
from morph.errors import OutputError

Asks = Callable[..., tuple[int, dict[str, str], bytes]]
People = Callable[..., Any]

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (1.0, 1.0, 1.0),
    "fov": 0.5,
    "near": 0.1,
    "far": 10.0,
    "image_width": 9,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""What a page says of its camera, but for its picture's height."""


@pytest.fixture
def door() -> Iterator[Door]:
    door = open_door("127.0.0.1", 0, "morph")
    yield door
    door.close()


@pytest.fixture
def open_to_all(still: type[View]) -> Iterator[Viewer]:
    viewer = Viewer(lambda: [still()], host="0.0.0.0", port=0)
    yield viewer
    viewer.close()


def test_the_page_is_packed_for_who_takes_it_packed(door: Door, asks: Asks) -> None:
    port = door.server.get_port()
    status, headers, plain = asks(port)
    assert (status, headers.get("content-encoding")) == (200, None)
    assert b"<html" in plain
    status, headers, packed = asks(port, Accept_Encoding="br, gzip")
    assert (status, headers["content-encoding"]) == (200, "gzip")
    assert gzip.decompress(packed) == plain


def test_every_answer_forbids_to_be_framed_kept_or_guessed_at(door: Door, asks: Asks) -> None:
    for path in ("/", "/nothing"):
        _, headers, _ = asks(door.server.get_port(), path)
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "no-referrer"
        assert headers["cache-control"] == "no-store"


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "[::1]", "LocalHost"])
def test_this_machine_is_answered_by_each_of_its_names_at_any_port(
    door: Door, asks: Asks, host: str
) -> None:
    port = door.server.get_port()
    # Another port is what `ssh -L 9000:localhost:8080` makes of it.
    for named in (host, f"{host}:{port}", f"{host}:9000"):
        assert asks(port, Host=named)[0] == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "localhost.evil.example", "192.0.2.5", "localhost@evil.example", "", "a b"],
)
def test_a_name_of_somebody_else_that_leads_here_is_refused(
    door: Door, asks: Asks, host: str
) -> None:
    port = door.server.get_port()
    for named in (host, f"{host}:{port}"):
        status, _, body = asks(port, Host=named)
        assert status == 403
        assert b"not served under that name" in body


@pytest.mark.parametrize(
    "path",
    ["/index.htm", "/index.html", "/../door.py", "/%2e%2e/x", "//", "/etc/passwd", "/favicon.ico"],
)
def test_there_is_one_page_and_no_file(door: Door, asks: Asks, path: str) -> None:
    assert asks(door.server.get_port(), path)[0] == 404


def test_no_address_can_have_the_page_obey_another_server(door: Door, asks: Asks) -> None:
    status, headers, _ = asks(door.server.get_port(), "/?websocket=ws://evil.example")
    assert (status, headers["location"]) == (303, "/")


@pytest.mark.parametrize(
    ("how", "status"),
    [
        ({"origin": "http://evil.example"}, 403),
        ({"origin": "null"}, 403),
        ({"origin": None}, 403),
        ({"origin": "http://localhost:1"}, 403),
        ({"path": "/other"}, 403),
        ({"speaks": "viser-v0.0.1"}, 400),
    ],
)
def test_only_our_own_page_speaks_with_us(
    door: Door, people: People, how: dict[str, Any], status: int
) -> None:
    from websockets.exceptions import InvalidStatus

    with pytest.raises(InvalidStatus, match=str(status)):
        people(door.server.get_port(), **how)
    # And our own page does.
    people(door.server.get_port())


def test_no_page_has_the_server_opened_to_the_world_or_sends_it_files(
    viewer: Viewer, people: People, waits: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from viser import ViserServer

    opened: list[str] = []
    monkeypatch.setattr(ViserServer, "request_share_url", lambda self: opened.append("to all"))
    monkeypatch.setattr(ViserServer, "disconnect_share_url", lambda self: opened.append("closed"))
    person = people(viewer.door.server.get_port()).enters()
    waits(lambda: viewer.sessions)
    person.says(type="ShareUrlRequest")
    person.says(type="ShareUrlDisconnect")
    whole = {"filename": "a", "mime_type": "text/plain", "part_count": 1, "size_bytes": 10**9}
    person.says(
        type="FileTransferStartUpload", source_component_uuid="1", transfer_uuid="2", **whole
    )
    # Messages are answered in their order: when this camera is here, those before were seen.
    person.says(**CAMERA, image_height=77)
    client = next(iter(viewer.door.server.get_clients().values()))
    waits(lambda: client.camera.image_height == 77)
    assert opened == []
    for gui in (viewer.door.server.gui, client.gui):
        assert not gui._current_file_upload_states


def test_open_to_the_network_it_asks_for_its_token(open_to_all: Viewer, asks: Asks) -> None:
    port = open_to_all.door.server.get_port()
    assert open_to_all.door.is_open
    assert "open to the network" in open_to_all.door.notes[-1]
    for path in ("/", "/?token=", "/?token=wrong", "/?token=%C3%A4", "/?token=a&token=b"):
        status, headers, body = asks(port, path)
        assert status == 401
        assert b"asks for a token" in body
        assert "set-cookie" not in headers


def test_the_token_is_shown_once_and_remembered_by_a_cookie(
    open_to_all: Viewer, asks: Asks, people: People
) -> None:
    from websockets.exceptions import InvalidStatus

    port = open_to_all.door.server.get_port()
    path = re.sub(r"^http://[^/]+", "", open_to_all.address)
    # 24 bytes of chance: 32 letters.
    assert re.fullmatch(r"/\?token=[\w-]{32}", path)
    status, headers, body = asks(port, path)
    assert status == 200
    assert b'content="0;url=/"' in body
    cookie, *marks = headers["set-cookie"].split("; ")
    assert set(marks) == {"Path=/", "HttpOnly", "SameSite=Strict"}
    assert cookie.startswith(f"morph_{port}=")
    assert b"<html" in asks(port, Cookie=f"other=1; {cookie}")[2]
    for wrong in ("", f"morph_{port}=wrong", cookie.replace(str(port), "1"), f"{cookie}x"):
        assert asks(port, Cookie=wrong)[0] == 401
        with pytest.raises(InvalidStatus, match=r"401"):
            people(port, {"Cookie": wrong})
    people(port, {"Cookie": cookie})
    # A page of somebody else has the browser's cookie sent, but says where it is from.
    with pytest.raises(InvalidStatus, match=r"403"):
        people(port, {"Cookie": cookie}, origin="http://evil.example")


def test_a_viser_that_serves_in_another_way_is_not_let(monkeypatch: pytest.MonkeyPatch) -> None:
    import viser

    class Other:
        stopped = False

        def __init__(self, **how: Any) -> None:
            assert how["host"] == "127.0.0.1"

        def stop(self) -> None:
            Other.stopped = True

    monkeypatch.setattr(viser, "ViserServer", Other)
    with pytest.raises(OutputError, match=r"not guarded here"):
        open_door("0.0.0.0", 0, "morph")
    assert Other.stopped


def test_a_door_that_closes_gives_its_port_back() -> None:
    door = open_door("127.0.0.1", 0, "morph")
    port = door.server.get_port()
    door.close()
    place = bound("127.0.0.1", port)
    place.socket.close()
    assert place.port == port


def test_what_others_serve_by_the_same_library_meanwhile_is_theirs() -> None:
    from websockets.asyncio import server

    before = server.serve
    door = open_door("127.0.0.1", 0, "morph")
    assert server.serve is before
    door.close()
