"""Token and Host/Origin checks in front of viser."""

from __future__ import annotations

import hmac
import logging
import re
from collections.abc import Callable
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qs

from morph.app.viewer.binding import BoundSocket
from morph.app.viewer.front_page import FrontPage

LOG = logging.getLogger(__name__)

MOST = 40
"""Pages that are connected at one time; a session says so sooner, in a sentence of its own."""

HOST = re.compile(r"(?P<name>[\w.-]+|\[[0-9A-Fa-f:.]+\])(:(?P<port>\d{1,5}))?", re.ASCII)
"""What a browser may call us."""

ALWAYS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    # A page of yesterday's program would not understand today's.
    "Cache-Control": "no-store",
}
"""Headers of every answer."""

ENTERING = """<!doctype html><meta charset="utf-8"><title>morph</title>
<meta http-equiv="refresh" content="0;url=/"><a href="/">Go on to the viewer</a>
"""
"""What the address with the token shows for a moment.

A page and no redirection: what a page leads to itself is sent the strict cookie even when a
link from elsewhere led to the page.
"""


class RequestGuard:
    """Answers with the page, with a refusal in a sentence, or with None: let viser answer.

    Args:
        place: Where it is served.
        token: What those must know who come in; None for nothing.
        page: What is served.
        protocol: What a page of ours speaks on its websocket.
        people: How many pages are connected.
    """

    def __init__(
        self,
        place: BoundSocket,
        token: str | None,
        page: FrontPage,
        *,
        protocol: str,
        people: Callable[[], int],
    ) -> None:
        """Stand at the door."""
        self._place, self._token, self._page = place, token, page
        self._protocol, self._people = protocol, people

    def answer(self, connection: Any, request: Any) -> Any:
        """Return the answer to a request, a `websockets.http11.Response`, or None.

        Whatever goes wrong here lets nobody in.
        """
        try:
            host = self._host(request)
            if host is None:
                return refused(
                    HTTPStatus.FORBIDDEN,
                    "This viewer is not served under that name: "
                    "use the address that it told when it started.",
                )
            path, _, query = request.path.partition("?")
            if request.headers.get("Upgrade") is not None:
                return self._connects(request, host, path)
            return self._looks(request, host, path, query)
        except Exception:
            LOG.exception("a request could not be answered")
            return refused(HTTPStatus.BAD_REQUEST, "This request is not understood.")

    def _host(self, request: Any) -> str | None:
        """Return what the browser calls us; None if it is not for us to answer to.

        A name of somebody else that leads to this machine would make their pages ours ("DNS
        rebinding"). Where a token is asked, no page under another name has it.
        """
        hosts = request.headers.get_all("Host")
        result = HOST.fullmatch(hosts[0]) if len(hosts) == 1 else None
        if result is None:
            return None
        if self._place.names and result["name"].lower() not in self._place.names:
            return None
        return str(hosts[0])

    def _connects(self, request: Any, host: str, path: str) -> Any:
        """Let a websocket in that comes from our own page; every browser says where from."""
        headers = request.headers
        if headers.get_all("Origin") != [f"http://{host}"] or path != "/":
            return refused(
                HTTPStatus.FORBIDDEN, "Only the viewer's own page may speak with the viewer."
            )
        if not self._known(request):
            return self._stranger()
        offered = ",".join(headers.get_all("Sec-WebSocket-Protocol")).split(",")
        if self._protocol not in (each.strip() for each in offered):
            return refused(
                HTTPStatus.BAD_REQUEST, "This page is of another version: load it again."
            )
        if self._people() >= MOST:
            return refused(HTTPStatus.SERVICE_UNAVAILABLE, "Too many pages look already.")
        return None

    def _looks(self, request: Any, host: str, path: str, query: str) -> Any:
        """Answer a browser that asks for the page."""
        if path != "/":
            return refused(HTTPStatus.NOT_FOUND, "There is only one page here: /")
        if self._token is not None:
            given = parse_qs(query).get("token", [])
            if len(given) == 1 and _same(given[0], self._token):
                cookie = f"{self._cookie}={self._token}; Path=/; HttpOnly; SameSite=Strict"
                return _answered(HTTPStatus.OK, ENTERING.encode(), {"Set-Cookie": cookie})
        if not self._known(request):
            return self._stranger()
        if query:
            # viser's page can be told by its address to obey another server; ours cannot.
            return _answered(HTTPStatus.SEE_OTHER, b"", {"Location": "/"})
        return self._shown(request, host)

    def _shown(self, request: Any, host: str) -> Any:
        packs = "gzip" in ",".join(request.headers.get_all("Accept-Encoding")).lower()
        headers = {"Content-Security-Policy": self._page.policy(host), "Vary": "Accept-Encoding"}
        if packs:
            headers["Content-Encoding"] = "gzip"
        return _answered(HTTPStatus.OK, self._page.packed if packs else self._page.plain, headers)

    @property
    def _cookie(self) -> str:
        # Browsers give the cookies of one port to all ports of a machine.
        return f"morph_{self._place.port}"

    def _known(self, request: Any) -> bool:
        if self._token is None:
            return True
        cookies = ";".join(request.headers.get_all("Cookie")).split(";")
        pairs = (cookie.strip().partition("=") for cookie in cookies)
        return any(name == self._cookie and _same(value, self._token) for name, _, value in pairs)

    def _stranger(self) -> Any:
        return refused(
            HTTPStatus.UNAUTHORIZED,
            "This viewer asks for a token: use the whole address, with ?token=..., "
            "that it told in the terminal when it started.",
        )


def refused(status: HTTPStatus, why: str) -> Any:
    """Return a refusal, in a sentence."""
    return _answered(status, f"{why}\n".encode(), {"Content-Type": "text/plain; charset=utf-8"})


def _answered(status: HTTPStatus, body: bytes, more: dict[str, str]) -> Any:
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    headers = Headers({"Content-Type": "text/html; charset=utf-8", **ALWAYS, **more})
    headers["Content-Length"] = str(len(body))
    headers["Connection"] = "close"
    if "Content-Security-Policy" not in more:
        headers["Content-Security-Policy"] = "default-src 'none'; frame-ancestors 'none'"
    return Response(status.value, status.phrase, headers, body)


def _same(given: str, token: str) -> bool:
    """Return whether a token is the right one, in a time that does not tell how nearly."""
    return hmac.compare_digest(given.encode(errors="replace"), token.encode())
