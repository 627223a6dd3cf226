"""The exported page opened from disk in a browser that has no network."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from morph.app.cli.main import main


def test_a_written_page_plays_and_jumps_without_a_network(
    blank: Callable[..., Any], tmp_path: Path
) -> None:
    path = tmp_path / "two <b> bodies.html"
    words = ["view", "cartpole", "pendulum", "--task", "balance", "--seconds", "3", "--quiet"]
    assert main([*words, "--html", str(path)]) == 0
    assert path.stat().st_size < 5_000_000
    person = blank(offline=True)
    person.page.goto(path.as_uri())
    film = person.page.frame_locator("iframe")
    film.get_by_role("slider").first.wait_for(state="attached")
    person.until(lambda: person.colours() > 200, "the bodies are drawn")
    for name in ("cartpole", "pendulum", "torque margin"):
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
    before = person.settled()
    click(0.9)
    person.until(lambda: person.changes(before), "the bodies are elsewhere then")
    # Nothing was asked for but the page itself.
    assert {each.partition(":")[0] for each in person.requests} <= {"file", "data", "blob"}
    assert sum(each.startswith("file:") for each in person.requests) == 1
    assert isinstance(before, np.ndarray)
