"""The exported page opened from disk in a browser that has no network."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from morph.app.cli.main import main


def test_a_written_page_plays_and_jumps_without_a_network(
    blank: Callable[..., Any], tmp_path: Path
) -> None:
    path = tmp_path / "two <b> bodies.html"
    words = ["view", "cartpole", "pendulum", "--task", "balance", "--seconds", "3", "--quiet"]
    assert main([*words, "--html", str(path)]) == 0
    assert path.stat().st_size < 5_000_000
    # Its player is watched as it plays: it draws as often as it asks, in the size that clips fit.
    person = blank(offline=True, hurried=True, viewport={"width": 960, "height": 600})
    person.page.goto(path.as_uri())
    film = person.page.frame_locator("iframe")
    # The player's slider has a thumb that is not drawn.
    film.locator('[role="slider"]').wait_for(state="attached")

    def picture() -> np.ndarray:
        # The middle of the canvas; messages of viser stand above, its player below.
        shot = person.page.screenshot(clip={"x": 0, "y": 200, "width": 880, "height": 480})
        return np.array(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)

    def colours() -> int:
        red, green, blue = np.moveaxis(picture(), -1, 0)
        return len(np.unique(red << 16 | green << 8 | blue))

    person.until(lambda: colours() > 200, "the bodies are drawn")
    for name in ("cartpole", "pendulum", "Made by morph"):
        assert name in person.text()

    def now() -> float:
        style = "getComputedStyle(document.documentElement).getPropertyValue('--morph-now')"
        return float(person.page.evaluate(style) or 0.0)

    began = now()
    person.until(lambda: now() != began, "the cursors move with the player")
    person.page.keyboard.press("Space")
    person.until(lambda: film.locator("svg.tabler-icon-player-play-filled").count(), "it pauses")

    def click(share: float) -> None:
        chart = person.page.locator("svg.chart").first
        chart.scroll_into_view_if_needed()
        box = chart.bounding_box()
        left, wide = (float(chart.get_attribute(f"data-{name}")) for name in ("left", "wide"))
        person.page.mouse.click(
            box["x"] + box["width"] * (left + share * wide), box["y"] + 0.4 * box["height"]
        )
        # A pixel of the chart is a part in 300 of its width.
        person.until(lambda: abs(now() - share) < 0.01, "a click on a chart jumps there")

    click(0.25)
    before = picture()
    click(0.9)
    # Where a body was or is, colours differ by more than at edges that are drawn more finely.
    person.until(
        lambda: (np.abs(picture() - before).max(axis=2) > 40).mean() > 2e-3,
        "the bodies are elsewhere then",
    )
    # 0.9 of 3 s is 2.7 s; two keys of a second each go to 0.7 s, if the second is still heard.
    for _ in range(2):
        person.page.keyboard.press("Shift+ArrowLeft")
    person.until(lambda: abs(now() - 0.7 / 3.0) < 0.01, "keys step, one after another")
    # Nothing was asked for but the page itself.
    assert {each.partition(":")[0] for each in person.requests} <= {"file", "data", "blob"}
    assert sum(each.startswith("file:") for each in person.requests) == 1
