"""A headless Chromium, and what a page draws in it."""

from __future__ import annotations

import io
import shutil
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from morph.errors import ViewError

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

FLAGS = ("--no-sandbox", "--use-angle=gl-egl", "--ignore-gpu-blocklist")
"""With these WebGL is drawn without a graphics card and without a display."""

WIDTH, HEIGHT = 1280, 760
"""Of the page."""

LEAST = 200
"""Triangles; viser's ground and helpers have some dozens, and any body has more."""

SETTLED = 0.5
"""s without more of them, after which all bodies are drawn."""

COLOURS = 200
"""Of a picture that shows something; an empty page has one."""

TRIANGLES = """(() => {
  window.drawn = 0; window.most = 0; window.frames = 0;
  const count = (name, at, copies) => {
    const was = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...given) {
      if (given[0] === 4) window.drawn += given[at] / 3 * (copies ? given[copies] : 1);
      return was.apply(this, given);
    };
  };
  count('drawElements', 1); count('drawArrays', 2);
  count('drawElementsInstanced', 1, 4); count('drawArraysInstanced', 2, 3);
  (function each() {
    window.most = Math.max(window.most, window.drawn); window.drawn = 0; window.frames += 1;
    requestAnimationFrame(each);
  })();
})()"""
"""Counts the triangles that are drawn between two frames, and the most that ever were."""


def free_port() -> int:
    """Return a port that nobody has."""
    with socket.socket() as asked:
        asked.bind(("127.0.0.1", 0))
        return int(asked.getsockname()[1])


@contextmanager
def browsing() -> Iterator[Any]:
    """Run a browser of playwright's until the block ends.

    Raises:
        ViewError: There is none.
    """
    from playwright.sync_api import sync_playwright

    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        raise ViewError(
            "there is no Chromium", where=", ".join(NAMES), fix="run `make browser` as root"
        )
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=found, args=list(FLAGS))
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def page_of(browser: Any) -> Iterator[Any]:
    """Open an empty page that counts triangles, until the block ends."""
    page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT})
    page.add_init_script(TRIANGLES)
    try:
        yield page
    finally:
        page.close()


def first_frame(page: Any, address: str, patience: float = 60.0) -> tuple[float, int]:
    """Open an address; return after how long its bodies stand on the screen, s, and triangles.

    They stand there when a picture of the screen has come back that was asked for after as many
    triangles were drawn as half a second later. So it is told late by that half second and the
    time of a picture, and never too early.

    Raises:
        ViewError: Nothing is drawn.
    """
    began = time.monotonic()
    page.goto(address)
    most, grown = 0, began
    while most < LEAST or time.monotonic() - grown < SETTLED:
        if time.monotonic() - began > patience:
            raise ViewError(
                f"after {patience:.0f} s only {most} triangles are drawn",
                where=address,
                fix="look at it in a browser",
            )
        page.wait_for_timeout(20)
        if (now := int(page.evaluate("window.most"))) > most:
            most, grown = now, time.monotonic()
    if colours(page) < COLOURS:
        raise ViewError("the canvas is blank", where=address, fix="look at it in a browser")
    return time.monotonic() - began, most


def colours(page: Any) -> int:
    """Return how many colours the picture of a page's canvas has."""
    import numpy as np
    from PIL import Image

    box = page.locator("canvas").first.bounding_box()
    clip = {"x": box["x"], "y": box["y"], "width": min(box["width"], 880.0), "height": HEIGHT}
    picture = np.array(Image.open(io.BytesIO(page.screenshot(clip=clip))).convert("RGB"))
    return len(np.unique(picture.reshape(-1, 3), axis=0))


def heap(page: Any) -> float:
    """Return how much a page's scripts hold after a collection, MB (1e6 bytes)."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    found = session.send("Runtime.getHeapUsage")
    session.detach()
    # Arrays that a graphics card reads lie beside the heap proper.
    return float(1e-6 * (found["usedSize"] + found.get("backingStorageSize", 0.0)))
