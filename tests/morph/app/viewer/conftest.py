"""A person at the viewer without a browser: a socket that speaks as viser's page does."""

from __future__ import annotations

import http.client
import logging
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from morph.app.viewer.content import Actor, Content
from morph.app.viewer.figure import figure
from morph.app.viewer.motion import motion
from morph.app.viewer.server import Viewer
from morph.app.viewer.view import View
from morph.body.load import load
from morph.sim.simulator import Simulator

PATIENCE = 60.0
"""s; what is waited for comes in milliseconds, but the machine may be busy."""

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (3.0, 3.0, 3.0),
    "fov": 0.8,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 760,
    "image_width": 890,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""With this a page says that it is there."""


def until(holds: Callable[[], Any]) -> Any:
    """Wait until something holds, and return it."""
    end = time.monotonic() + PATIENCE
    while not (found := holds()):
        assert time.monotonic() < end, "it never came"
        time.sleep(0.005)
    return found


@pytest.fixture(autouse=True)
def heard(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> Iterator[None]:
    """Hear the viewer's log, whatever libraries of other tests have done to loggers."""
    before = logging.root.manager.disable
    logging.disable(logging.NOTSET)
    for name in ("morph", "morph.app", "morph.app.viewer", "morph.app.viewer.session"):
        monkeypatch.setattr(logging.getLogger(name), "disabled", False)
        monkeypatch.setattr(logging.getLogger(name), "propagate", True)
    with caplog.at_level(logging.INFO, logger="morph.app.viewer"):
        yield
    logging.disable(before)


class Person:
    """One who has opened the page.

    Args:
        port: Where.
        headers: What else the browser says.
        origin: Where its page is from; by default from there.
        host: What the browser calls the server.
    """

    def __init__(
        self,
        port: int,
        headers: dict[str, str] | None = None,
        *,
        origin: str | None = "",
        path: str = "/",
        speaks: str = "",
    ) -> None:
        import viser
        from websockets.sync.client import connect

        self.socket: Any = connect(
            f"ws://localhost:{port}{path}",
            origin=f"http://localhost:{port}" if origin == "" else origin,  # type: ignore[arg-type]
            subprotocols=[speaks or f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            additional_headers=headers or {},
            max_size=None,
            compression=None,
            proxy=None,
            # What nobody reads must not keep one from leaving.
            max_queue=None,
            close_timeout=1.0,
        )

    def says(self, **message: Any) -> None:
        """Send a message."""
        import msgspec.msgpack

        self.socket.send(msgspec.msgpack.encode(message))

    def enters(self) -> Person:
        """Say where the camera is: with that one is there."""
        self.says(**CAMERA)
        return self

    def hears(self, kind: str, holding: str = "") -> dict[str, Any]:
        """Return the next message of a kind whose text holds something."""
        import msgspec.msgpack
        from zstandard import ZstdDecompressor

        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            frame = self.socket.recv(timeout=PATIENCE)
            words = frame[16 : 16 + int.from_bytes(frame[8:16], "little")]
            for message in msgspec.msgpack.decode(ZstdDecompressor().decompress(words))["messages"]:
                if message["type"] == kind and holding in str(message):
                    found: dict[str, Any] = message
                    return found
        raise AssertionError(f"no {kind} came")

    def leaves(self) -> None:
        """Close the page."""
        self.socket.close()


class Still(View):
    """One body; a button that fails, and one that is our own refusal."""

    name = "still"
    title = "Still"
    shown: Content

    def content(self) -> Content:
        return self.shown


@pytest.fixture(scope="session")
def shown() -> Content:
    """A pendulum that swings for a second."""
    robot = load("pendulum")
    simulator = Simulator(robot)
    swing = simulator.trajectory(seconds=1.0, start={"hinge": 1.0})
    moves = motion(simulator.model, swing.time, swing.position)
    return Content(actors=(Actor(figure=figure(robot), motion=moves),))


@pytest.fixture
def still(shown: Content) -> type[View]:
    """A view of it."""
    return type("Swinging", (Still,), {"shown": shown})


@pytest.fixture
def viewer(still: type[View]) -> Iterator[Viewer]:
    """A viewer of it, which anybody of this machine may open."""
    viewer = Viewer(lambda: [still()], port=0)
    yield viewer
    viewer.close()


@pytest.fixture
def people() -> Iterator[Callable[..., Person]]:
    """What opens the page at a port; all leave at the end."""
    came: list[Person] = []

    def person(port: int, headers: dict[str, str] | None = None, **how: Any) -> Person:
        came.append(Person(port, headers, **how))
        return came[-1]

    # Those who left may be forgotten, where it is counted what is left of them.
    person.forget = came.clear  # type: ignore[attr-defined]
    yield person
    for each in came:
        each.leaves()


@pytest.fixture
def waits() -> Callable[[Callable[[], Any]], Any]:
    """What waits until something holds."""
    return until


@pytest.fixture
def asks() -> Callable[..., tuple[int, dict[str, str], bytes]]:
    """What asks a port for a page, and gives back the status, the headers and the body."""

    def ask(
        port: int, path: str = "/", at: str = "127.0.0.1", **headers: str
    ) -> tuple[int, dict[str, str], bytes]:
        connection = http.client.HTTPConnection(at, port, timeout=PATIENCE)
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        connection.request("GET", path, headers={"Host": f"localhost:{port}", **named})
        answer = connection.getresponse()
        body = answer.read()
        connection.close()
        return answer.status, {key.lower(): value for key, value in answer.getheaders()}, body

    return ask
