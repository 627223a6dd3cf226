"""From the command to the first frame: how long it takes, how much is sent, what it holds."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

from experiments.viewed.browser import first_frame, free_port, heap, page_of
from experiments.viewed.listener import listened
from experiments.viewed.served import memory, serving
from morph.arrays import JSON

EMPTY = """
import sys, time, viser
viser.ViserServer(host="127.0.0.1", port=int(sys.argv[1]), verbose=False)
sys.stderr.write("served\\n"); sys.stderr.flush()
time.sleep(600)
"""
"""The control of memory: viser with nothing to show, and none of our code."""


def sent(words: str) -> JSON:
    """Return when all that is to be seen was sent, s after the command, and how much, MB.

    Args:
        words: What `morph view` is told.
    """
    with serving(*words.split()) as served:
        came = listened(served.address)
    return {
        "words": words,
        "told_s": served.told - served.began,
        "sent_s": came.last - served.began,
        "shapes": came.shapes,
        "sent_mb": 1e-6 * came.shape_bytes,
    }


def framed(browser: Any, words: str) -> JSON:
    """Return when bodies stood on the screen, s after the command.

    Args:
        browser: A browser of playwright's that runs already, without a page.
        words: What `morph view` is told.
    """
    with serving(*words.split()) as served, page_of(browser) as page:
        after, triangles = first_frame(page, served.address)
    return {
        "words": words,
        "frame_s": served.told - served.began + after,
        "triangles": triangles,
    }


def held(browser: Any, words: str) -> JSON:
    """Return what the server and the page hold while bodies are looked at, MB (1e6 bytes).

    The page's are what its scripts hold after a collection, its arrays included; what a
    graphics card or its driver holds is in neither.
    """
    with serving(*words.split()) as served, page_of(browser) as page:
        first_frame(page, served.address)
        page.wait_for_timeout(2000)
        now, most = served.memory()
        scripts = heap(page)
    return {"words": words, "server_mb": now, "server_peak_mb": most, "page_mb": scripts}


def held_by_nothing(browser: Any) -> JSON:
    """Return the same of viser alone with an empty scene."""
    port = free_port()
    process = subprocess.Popen(
        [sys.executable, "-c", EMPTY, str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        if process.stderr is not None:
            process.stderr.readline()
        with page_of(browser) as page:
            page.goto(f"http://127.0.0.1:{port}")
            page.wait_for_timeout(4000)
            now, most = memory(process.pid)
            scripts = heap(page)
    finally:
        process.kill()
        process.communicate()
    return {
        "words": "viser alone",
        "server_mb": now,
        "server_peak_mb": most,
        "page_mb": scripts,
    }
