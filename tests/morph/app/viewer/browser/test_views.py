from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from morph.app.cli.main import main
from morph.app.viewer.views.views import VIEWS


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What all four views together need, made by the commands that people give."""
    folder = tmp_path_factory.mktemp("inputs")
    aligned, run = folder / "aligned", folder / "run.parquet"
    assert main(["align", "cartpole", "rider_rigid_driven", "--out", str(aligned), "--quiet"]) == 0
    swings = ["simulate", "pendulum", "--start", "hinge=0.5", "--seconds", "3", "--out", str(run)]
    assert main(swings) == 0
    return {"transfer": aligned, "recordings": (run,)}


def test_every_view_opens_plays_and_is_scrubbed(
    served: Callable[..., Any], look: Callable[..., Any], inputs: dict[str, Path]
) -> None:
    viewer = served("pendulum", "cartpole", **inputs)
    person = look(viewer.address)
    (session,) = viewer.sessions
    assert {view.name for view in session.views} == set(VIEWS)
    for view in session.views:
        opens_plays_and_is_scrubbed(person, session, view)


def opens_plays_and_is_scrubbed(person: Any, session: Any, view: Any) -> None:
    person.press(view.title)
    person.until(lambda: session.view is view, f"{view.title} is open")
    person.until(lambda: session.content.actors, "there are bodies")
    person.until(lambda: person.colours() > 200, "the canvas shows something")
    # A body under a designer's hand has a pose and no motion.
    if view.name == "design":
        return
    person.until(lambda: session.content.seconds > 0.0, "there is a motion")
    handle = person.page.get_by_role("slider").first
    handle.focus()
    person.page.keyboard.press("Home")
    person.until(lambda: session.clock.time == 0.0, "scrubbed to the start")
    assert not session.clock.playing
    start = person.settled()
    person.press("Play")
    person.until(lambda: person.changes(start), "it moves")
    assert session.clock.time > 0.0
    assert "That did not work" not in person.text()
