"""How fluently the viewer moves bodies of many links while a browser looks on."""

from __future__ import annotations

import resource
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments.viewed.browser import free_port, page_of
from morph.app.viewer.content import Actor, Content, Tie
from morph.app.viewer.figure import Figure, figure
from morph.app.viewer.motion import RATE, MotionFrames, posed
from morph.app.viewer.server import Viewer
from morph.app.viewer.view import View
from morph.arrays import JSON
from morph.body.load import load

SECONDS = 12.0
"""How long is measured; the motion is as long, and comes again."""

SETTLES = 5.0
"""s before, for the page to be drawn."""

PULLS = 8
"""Arrows and lines of a busy scene."""

WATCHED = """() => {
  window.updates = 0; window.frames = 0; window.last = '';
  new MutationObserver(() => {
    const text = document.getElementById('updates')?.textContent;
    if (text !== window.last) { window.updates += 1; window.last = text; }
  }).observe(document.body, {subtree: true, childList: true, characterData: true});
  (function each() { window.frames += 1; requestAnimationFrame(each); })();
}"""
"""Counts what reaches the page, and how often it is drawn."""


@dataclass
class Count:
    """What happened so far."""

    updates: int = 0
    """Pictures that were sent."""
    processor: float = 0.0
    """Time of a core that the session's thread took, s."""

    def now(self) -> tuple[int, float]:
        """Return both."""
        return self.updates, self.processor


class Many(View):
    """Made-up bodies of many links that all move."""

    name, title = "compare", "Compare"

    def __init__(self, content: Content) -> None:
        """Show it."""
        self._content = content

    def content(self) -> Content:
        """Return it."""
        return self._content


def speed(browser: Any, links: int, *, bodies: int = 1, busy: bool = False) -> JSON:
    """Return how many updates a second are sent, reach the page, and are drawn.

    Args:
        browser: Of playwright's.
        links: Of all bodies together; every one moves in every picture.
        bodies: How many bodies they make up.
        busy: Whether arrows, heat, a marker and lines between the bodies are drawn too.
    """
    content = _content(links, bodies, busy=busy)
    viewer = Viewer(lambda: (Many(content),), port=free_port())
    try:
        with page_of(browser) as page:
            page.goto(viewer.address)
            page.wait_for_timeout(1000.0 * SETTLES)
            count = _counted(viewer.sessions[0])
            page.evaluate(WATCHED)
            page.wait_for_timeout(1000.0)
            seen = _seen(page)
            before, began, whole = count.now(), time.monotonic(), time.process_time()
            time.sleep(SECONDS)
            sent, took, process = count.now(), time.monotonic() - began, time.process_time() - whole
            # A page that is slow to answer counts by its own clock.
            shown = [now - then for now, then in zip(_seen(page), seen, strict=True)]
    finally:
        viewer.close()
    return {
        "links": links,
        "bodies": bodies,
        "busy": busy,
        "sent_hz": (sent[0] - before[0]) / took,
        "reached_hz": shown[0] / shown[2],
        "drawn_hz": shown[1] / shown[2],
        "thread_share": (sent[1] - before[1]) / took,
        "process_share": process / took,
        "rss_mb": 1e-3 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
    }


def _seen(page: Any) -> list[float]:
    """Return updates, frames, and when, s, as the page knows them."""
    found = page.evaluate("[window.updates, window.frames, 1e-3 * performance.now()]")
    return [float(each) for each in found]


def _counted(session: Any) -> Count:
    """Count the pictures of a session, and number them on its page."""
    count, pose = Count(), session.stage.pose
    number = session.client.gui.add_html('<i id="updates">0</i>')

    def counted(at: float) -> None:
        began = time.thread_time()
        pose(at)
        number.content = f'<i id="updates">{count.updates}</i>'
        count.updates += 1
        count.processor += time.thread_time() - began

    session.stage.pose = counted
    return count


def _content(links: int, bodies: int, *, busy: bool) -> Content:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "many.xml"
        path.write_text(_description(links // bodies), encoding="utf-8")
        drawn = figure(load(path))
    actors = tuple(Actor(figure=drawn, motion=_motion(drawn, busy=busy)) for _ in range(bodies))
    names, last = drawn.links[1:], bodies - 1
    ties = tuple(Tie(source=(0, name), target=(last, name)) for name in names[:PULLS])
    return Content(actors=actors, ties=ties if busy else ())


def _description(links: int) -> str:
    """Return links on hinges about a ring, as MJCF; each is told from a box and a ball."""
    angles = np.linspace(0.0, 2.0 * np.pi, links, endpoint=False)
    radius = 0.05 * links / np.pi
    parts = "".join(
        f'<body name="link_{at}" pos="{radius * np.cos(angle):.4f} {radius * np.sin(angle):.4f} 1">'
        f'<joint name="joint_{at}" axis="0 1 0"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" rgba="0.8 0.8 0.8 1"/>'
        '<geom type="sphere" pos="0 0 -0.3" size="0.04" rgba="0.9 0.5 0.1 1"/></body>'
        for at, angle in enumerate(angles)
    )
    return f'<mujoco model="many"><worldbody>{parts}</worldbody></mujoco>'


def _motion(drawn: Figure, *, busy: bool) -> MotionFrames:
    pictures = round(SECONDS * RATE) + 1
    time_of = np.arange(pictures) / RATE
    phase = np.linspace(0.0, 2.0 * np.pi, drawn.model.nq, endpoint=False)
    moved = posed(drawn.model, 0.6 * np.sin(3.0 * time_of[:, None] + phase))
    # A hinge's frame only turns; a link of a walker also goes.
    moved.position[:, 1:, 2] += 0.1 * np.sin(3.0 * time_of[:, None] + phase)
    if not busy:
        return moved
    starts = moved.position[:, 1 : 1 + PULLS]
    ends = starts + 0.3 * np.abs(np.sin(time_of))[:, None, None]
    return MotionFrames(
        position=moved.position,
        turn=moved.turn,
        arrows={"contact": np.stack((starts, ends), axis=2)},
        heat=0.5 + 0.5 * np.sin(time_of[:, None] + np.append(0.0, phase)),
        marks=starts[:, 0],
    )
