from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer
from typing import Any

import pytest

from morph.app.viewer.server import Viewer
from morph.app.viewer.session import Session
from morph.app.viewer.view import View

CONNECTS = """address => new Promise(told => {
  const socket = new WebSocket(address, ['viser-v' + '%s']);
  socket.onopen = () => told('open'); socket.onerror = () => told('refused');
})"""
"""What a page of somebody else may try."""


class Other(BaseHTTPRequestHandler):
    """Serves a page of somebody else."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b'<link rel="icon" href="data:,"><title>other</title>')

    def log_message(self, *told: Any) -> None:
        """Say nothing."""


@pytest.fixture
def elsewhere() -> Iterator[str]:
    """Where somebody else of this machine serves a page."""
    with HTTPServer(("127.0.0.1", 0), Other) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://localhost:{server.server_port}"
        server.shutdown()
        thread.join()


@pytest.fixture
def unguarded(still: type[View]) -> Iterator[Viewer]:
    """A viewer that is open to the network, with a view that escapes nothing."""

    class Careless(still):  # type: ignore[misc,valid-type]
        def panel(self, gui: Any, session: Session) -> None:
            gui.add_html('<b id="there"></b><img src="x" onerror="window.hacked = 1">')

    viewer = Viewer(lambda: [Careless()], host="0.0.0.0", port=0)
    yield viewer
    viewer.close()


def test_the_address_with_its_token_opens_the_page_and_html_of_others_runs_nothing(
    unguarded: Viewer, look: Callable[..., Any], blank: Callable[..., Any]
) -> None:
    stranger = blank()
    bare = unguarded.address.split("?")[0]
    stranger.page.goto(bare)
    assert "This viewer asks for a token" in stranger.text()
    assert all("401" in each for each in stranger.wrong)
    stranger.wrong.clear()

    person = look(unguarded.address)
    # The token is neither kept in the address nor to be read by a script.
    assert person.page.url == bare
    assert person.page.evaluate("document.cookie") == ""
    person.until(lambda: person.page.locator("#there").count(), "the HTML is there")
    refused = person.until(
        lambda: [each for each in person.wrong if "inline event handler" in each],
        "the browser refuses to run what stands in HTML",
    )
    assert refused
    assert person.page.evaluate("window.hacked") is None
    # Nothing else was refused that viser's page does by itself.
    assert all("Content Security Policy" in each for each in person.wrong)
    assert all("/x'" in each for each in set(person.wrong) - set(refused))
    person.wrong.clear()


def test_a_page_of_somebody_else_cannot_speak_with_the_viewer(
    viewer: Viewer, elsewhere: str, blank: Callable[..., Any]
) -> None:
    import viser

    person = blank()
    person.page.goto(viewer.address, wait_until="commit")
    try_it = CONNECTS % viser.__version__
    address = viewer.address.replace("http://", "ws://")
    # Ours can: what refuses the other is the door, not this test.
    assert person.page.evaluate(try_it, address) == "open"
    other = blank()
    other.page.goto(elsewhere)
    assert other.page.evaluate(try_it, address) == "refused"
    assert all("403" in each for each in other.wrong), other.wrong
    other.wrong.clear()
