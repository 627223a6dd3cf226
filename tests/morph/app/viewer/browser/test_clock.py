"""The clock on a page, held against a motion that is known in closed form."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
import pytest

from morph.app.viewer.content import Actor, Content
from morph.app.viewer.figure import Figure, figure
from morph.app.viewer.motion import RATE, posed
from morph.app.viewer.view import View
from morph.body.load import load

SECONDS = 4.0


class Turning(View):
    """A pendulum that is at one radian for every second."""

    name: ClassVar[str] = "turning"
    title: ClassVar[str] = "Turning"

    def __init__(self, drawn: Figure) -> None:
        angles = np.arange(round(SECONDS * RATE) + 1)[:, None] / RATE
        self._actor = Actor(figure=drawn, motion=posed(drawn.model, angles))

    def content(self) -> Content:
        return Content(actors=(self._actor,))


def height_of_ball(picture: np.ndarray) -> float:
    """How high the pendulum's ball is, as a share of the picture; nothing else is orange."""
    red, green, blue = np.moveaxis(picture.astype(int), -1, 0)
    rows, _ = np.nonzero((red > 150) & (red - blue > 90) & (red - green > 40))
    return float(1.0 - np.median(rows) / len(picture)) if len(rows) else float("nan")


@pytest.fixture
def viewer(served: Callable[..., Any]) -> Any:
    drawn = figure(load("pendulum"))
    return served(views=lambda: [Turning(drawn)])


def test_buttons_keys_and_slider_move_the_clock_of_one_page_and_its_body(
    viewer: Any,
    look: Callable[..., Any],
    people: Callable[..., Any],
    waits: Callable[..., Any],
) -> None:
    person = look(viewer.address)
    (mine,) = viewer.sessions
    people(viewer.door.server.get_port()).enters()
    person.until(lambda: len(viewer.sessions) == 2, "somebody else looks, too")
    (yours,) = set(viewer.sessions) - {mine}
    buttons_and_keys_hold_the_body_and_let_it_go(person, mine)
    a_scrubbed_clock_shows_the_pose_of_that_time(person, mine)

    held, passed = mine.clock.time, yours.clock.time
    person.until(lambda: yours.clock.time != passed, "the other's goes on")
    assert yours.clock.playing
    assert yours.clock.speed == 1.0
    assert mine.clock.time == held
    person.page.close()
    assert waits(lambda: viewer.sessions == (yours,)), "who leaves is gone"


def buttons_and_keys_hold_the_body_and_let_it_go(person: Any, session: Any) -> None:
    start = person.picture()
    person.until(lambda: person.changes(start), "the body moves")

    person.press("Pause")
    person.until(lambda: not session.clock.playing, "it pauses")
    held = person.settled()
    at = session.clock.time

    person.point()
    person.page.keyboard.press("Space")
    person.until(lambda: session.clock.playing, "the space bar plays")
    person.until(lambda: session.clock.time != at and person.changes(held), "the body moves again")
    person.page.keyboard.press("Space")
    person.until(lambda: not session.clock.playing, "the space bar pauses")

    person.page.keyboard.press("Home")
    person.until(lambda: session.clock.time == 0.0, "the key goes to the start")
    for _ in range(3):
        person.page.keyboard.press("ArrowRight")
    person.until(lambda: abs(session.clock.time - 3.0 / RATE) < 1e-9, "three pictures on")
    person.page.keyboard.press("ArrowLeft")
    person.until(lambda: abs(session.clock.time - 2.0 / RATE) < 1e-9, "one picture back")
    person.page.keyboard.press("Shift+ArrowUp")
    person.until(lambda: session.clock.speed == 2.0, "twice as fast")
    person.press("+1 s")
    person.until(lambda: abs(session.clock.time - 1.0 - 2.0 / RATE) < 1e-9, "a second on")
    person.press("-1 s")
    person.until(lambda: abs(session.clock.time - 2.0 / RATE) < 1e-9, "and back")


def a_scrubbed_clock_shows_the_pose_of_that_time(person: Any, session: Any) -> None:
    # At no radian the ball hangs by its length below the pivot, at two it stands 0.42 (-cos 2) of
    # it above: it has risen by 1.42 of its length, which is 0.3 to 0.5 of the picture.
    handle = person.page.get_by_role("slider").first
    handle.focus()
    person.page.keyboard.press("Home")
    person.until(lambda: session.clock.time == 0.0, "scrubbed to the start")
    assert not session.clock.playing
    person.until(lambda: height_of_ball(person.picture()) < 0.35, "it hangs")
    low = height_of_ball(person.settled())

    box = handle.bounding_box()
    across = person.page.locator(".mantine-Slider-track").first.bounding_box()
    assert box is not None
    assert across is not None
    y = box["y"] + 0.5 * box["height"]
    person.page.mouse.move(box["x"] + 0.5 * box["width"], y)
    person.page.mouse.down()
    for share in (0.1, 0.3, 0.5):
        person.page.mouse.move(across["x"] + share * across["width"], y)
    person.page.mouse.up()
    # Half of the track is half of the time; the handle's width makes some percent of it.
    person.until(lambda: abs(session.clock.time - 0.5 * SECONDS) < 0.1, "scrubbed to the middle")
    person.until(lambda: height_of_ball(person.picture()) > low + 0.3, "it stands high")
    shown = float(handle.get_attribute("aria-valuenow"))
    assert shown == pytest.approx(session.clock.time, abs=2e-3)

    person.point()
    person.page.keyboard.press("Home")
    person.until(lambda: session.clock.time == 0.0, "at the start again")
    person.until(lambda: height_of_ball(person.picture()) < low + 0.02, "it hangs again")
