"""The control of fluency: viser alone moves as many links, without any of our code."""

from __future__ import annotations

import threading
import time
from contextlib import redirect_stdout
from io import StringIO
from typing import Any

import numpy as np

from experiments.viewed.browser import free_port, page_of
from experiments.viewed.speed import SECONDS, SETTLES, WATCHED
from morph.arrays import JSON

RATE = 60.0
"""Updates a second that are tried."""


def raw_speed(browser: Any, links: int) -> JSON:
    """Return how many updates a second viser sends, and how many reach the page.

    Args:
        browser: Of playwright's.
        links: Frames with a ball each; every one moves and turns in every update.
    """
    from viser import ViserServer

    with redirect_stdout(StringIO()):
        server = ViserServer(host="127.0.0.1", port=free_port(), verbose=False)
    came, clients = threading.Event(), []

    def comes(client: Any) -> None:
        clients.append(client)
        came.set()

    server.on_client_connect(comes)
    try:
        with page_of(browser) as page:
            page.goto(f"http://127.0.0.1:{server.get_port()}")
            while not came.is_set():
                page.wait_for_timeout(50)
            frames, number = _scene(clients[0], links)
            page.wait_for_timeout(1000.0 * SETTLES)
            page.evaluate(WATCHED)
            before = int(page.evaluate("window.updates"))
            began = time.monotonic()
            sent = _moved(clients[0], frames, number)
            took = time.monotonic() - began
            reached = int(page.evaluate("window.updates")) - before
    finally:
        with redirect_stdout(StringIO()):
            server.stop()
    return {"links": links, "sent_hz": sent / took, "reached_hz": reached / took}


def _scene(client: Any, links: int) -> tuple[list[Any], Any]:
    frames = []
    for at in range(links):
        frames.append(client.scene.add_frame(f"/links/{at}", show_axes=False))
        client.scene.add_icosphere(f"/links/{at}/ball", radius=0.05, color=(200, 100, 50))
    return frames, client.gui.add_html('<i id="updates">0</i>')


def _moved(client: Any, frames: list[Any], number: Any) -> int:
    """Move all frames for `SECONDS`, and return how often."""
    phase = np.linspace(0.0, 2.0 * np.pi, len(frames), endpoint=False)
    rest = np.stack((np.cos(phase), np.sin(phase), np.ones(len(frames))), axis=1)
    began = time.monotonic()
    updates = 0
    while (now := time.monotonic()) < began + SECONDS:
        swing = np.sin(3.0 * now + phase)
        with client.atomic():
            for frame, place, angle in zip(frames, rest, swing, strict=True):
                frame.position = place + np.array([0.0, 0.0, 0.1 * angle])
                frame.wxyz = np.array([np.cos(0.3 * angle), 0.0, np.sin(0.3 * angle), 0.0])
            number.content = f'<i id="updates">{updates}</i>'
        updates += 1
        time.sleep(max(0.0, began + updates / RATE - time.monotonic()))
    return updates
