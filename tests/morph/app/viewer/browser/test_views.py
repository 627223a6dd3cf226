from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from morph.app.viewer.views.views import VIEWS


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
    shown = session.content if session.view is not view else None
    person.press(view.title)
    # Until then what the view before showed is still there, its motion too.
    opened = lambda: session.view is view and session.content is not shown  # noqa: E731
    person.until(opened, f"{view.title} is open")
    person.until(lambda: session.content.actors, "there are bodies")
    person.until(lambda: person.colours() > 200, "the canvas shows something")
    # A body under a designer's hand has a pose and no motion.
    if view.name == "design":
        return
    person.until(lambda: session.content.seconds > 0.0, "there is a motion")

    def scrubbed() -> bool:
        # The first slider may be one of the view before, and one at its start has nothing to say.
        person.page.get_by_role("slider").first.focus()
        person.page.keyboard.press("Home")
        return session.clock.time == 0.0 and not session.clock.playing

    person.until(scrubbed, "scrubbed to the start")
    start = person.settled()
    person.press("Play")
    person.until(lambda: person.changes(start), "it moves")
    assert session.clock.time > 0.0
    assert "That did not work" not in person.text()
