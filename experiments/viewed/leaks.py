"""Memory and threads before and after many people, beside what the browser's driver takes."""

from __future__ import annotations

import os
import threading
import time
from typing import Any

import numpy as np

from experiments.viewed.browser import free_port, page_of
from experiments.viewed.people import LOOKS, opened_and_closed
from experiments.viewed.served import memory
from morph.app.viewer.server import Viewer
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.views import makers
from morph.arrays import JSON
from morph.body.load import load

BODIES = ("cartpole", "hopper")
"""What those who come see."""

FEW = 40
"""Empty pages of the control: enough for a slope."""


def leaked(browser: Any, times: int) -> JSON:
    """Return what stays behind of pages that were opened and closed, by people and by nobody.

    Args:
        browser: A browser of playwright's, whose pages open; its driver is in this process too.
        times: How many, one after another.
    """
    robots = tuple(load(name) for name in BODIES)
    found, first = makers(ViewRequest(robots=robots, asked=BODIES))
    viewer = Viewer(lambda: [make() for make in found], first=first, port=free_port())
    try:
        control = _empty(browser, min(times, FEW))
        # The first one fills pools that stay: of threads, and of what is drawn.
        opened_and_closed(viewer, 1, browser)
        before = threading.active_count()
        people = opened_and_closed(viewer, times, browser)
        time.sleep(LOOKS)
        after = threading.active_count()
    finally:
        viewer.close()
    return {
        "times": times,
        "people_mb": people,
        "control_mb": control,
        "people_slope_mb": slope(people),
        "control_slope_mb": slope(control),
        "threads_before": before,
        "threads_after": after,
    }


def slope(memory_mb: list[float]) -> float:
    """Return by how much each page adds over the second half of them, MB, by least squares.

    The first fill caches and pools; what leaks goes on.
    """
    half = np.array(memory_mb[len(memory_mb) // 2 :])
    if len(half) < 2:
        return 0.0
    return float(np.polyfit(np.arange(len(half)), half, 1)[0])


def _empty(browser: Any, times: int) -> list[float]:
    """Open and close empty pages: the server runs and nobody comes."""
    found = []
    for _ in range(times):
        with page_of(browser) as page:
            page.goto("about:blank")
            page.wait_for_timeout(1e3 * LOOKS)
        found.append(memory(os.getpid())[0])
    return found
