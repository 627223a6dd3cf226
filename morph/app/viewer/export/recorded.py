"""Bodies that move as one page of viser's: its client, and all pictures within it."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from morph.app.viewer.camera import Camera
from morph.app.viewer.content import Actor, Content
from morph.app.viewer.serve import open_door
from morph.app.viewer.stage import Stage
from morph.arrays import Array

RATES = (30, 15, 10)
"""Pictures a second: as many as there is room for."""

REST = 0.5
"""How long the last picture stays before the first comes again, s."""

FIGURES = 2**16
"""Of a position or a turn as many steps are kept to each power of two, so that it packs well."""

LOOKS = (
    "<script>window.__VISER_EMBED_CONFIG__="
    '{darkMode:matchMedia("(prefers-color-scheme: dark)").matches};</script>'
)
"""Has viser's client be dark where the page around it is."""


@dataclass(frozen=True, kw_only=True)
class RecordedPage:
    """A page of viser's."""

    html: str
    """The page."""
    rate: int
    """Pictures a second."""


def recorded(
    content: Content,
    most: int,
    *,
    arrows: Collection[str] | None = None,
    following: bool = True,
    camera: Camera | None = None,
) -> RecordedPage:
    """Return the bodies and their motion as a page that needs no server.

    Args:
        content: What is shown.
        most: Bytes that it may have; more than that only where the slowest rate takes them.
        arrows: Kinds of arrows that are drawn; by default all.
        following: Whether what travels stays in the middle.
        camera: From where one looks at first; by default all bodies are seen.

    Raises:
        OutputError: This machine lets no server run, which viser needs to make it.
    """
    packed = replace(content, actors=tuple(_packed(actor) for actor in content.actors))
    door = open_door("127.0.0.1", 0, "morph")
    try:
        stage = Stage(door.server.scene)
        stage.following = following
        if arrows is not None:
            stage.shown_arrows = set(arrows)
        stage.show(packed)
        stage.pose(0.0)
        stage.aim(door.server.initial_camera)
        if camera is not None:
            camera.turn(door.server.initial_camera)
        for rate in RATES:
            html = _played(door.server, stage, content.seconds, rate)
            if len(html) <= most or content.seconds == 0.0:
                break
    finally:
        door.close()
    return RecordedPage(html=html.replace("</head>", f"{LOOKS}</head>", 1), rate=rate)


def _played(server: Any, stage: Stage, seconds: float, rate: int) -> str:
    stage.pose(0.0)
    kept = server.get_scene_serializer()
    for picture in range(1, round(seconds * rate) + 1):
        kept.insert_sleep(1.0 / rate)
        stage.pose(min(picture / rate, seconds))
    if seconds > 0.0:
        kept.insert_sleep(REST)
    html: str = kept.as_html()
    return html


def _packed(actor: Actor) -> Actor:
    motion = actor.motion
    return replace(
        actor,
        motion=replace(motion, position=rounded(motion.position), turn=rounded(motion.turn)),
    )


def rounded(values: Array) -> Array:
    """Return numbers whose last bits are zero: what is alike then packs into a third."""
    part, power = np.frexp(values)
    rounded: Array = np.ldexp(np.rint(part * FIGURES) / FIGURES, power)
    return rounded
