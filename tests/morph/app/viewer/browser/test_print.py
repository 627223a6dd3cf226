"""Print in a real Chromium."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def test_parts_come_apart_are_coloured_pointed_at_and_laid_on_the_bed(
    served: Callable[..., Any], look: Callable[..., Any]
) -> None:
    viewer = served("quadruped_printed", first="print")
    person = look(viewer.address)
    (session,) = viewer.sessions
    person.until(lambda: "P-02 upper leg" in person.text(), "parts are there")
    session.do(lambda: session.jump(0.0))
    person.until(lambda: session.clock.time == 0.0, "the body is together")
    together = person.settled()
    row = person.page.locator("label", has_text="apart (%)").locator("xpath=../../../..")
    row.locator("input").last.fill("100")
    person.until(lambda: session.clock.time == 2.0, "the slider takes the body apart")
    person.until(lambda: person.changes(together), "it is seen")
    plain = person.settled()
    choose(person, "colours", "overhang")
    person.until(lambda: "needs support" in person.text(), "it says what colours mean")
    person.until(lambda: person.changes(plain), "they are seen")
    choose(person, "point at", "lower_leg")
    person.until(lambda: "height as printed" in person.text(), "the part is told of")
    choose(person, "show", "plate_1")
    person.until(
        lambda: session.content.actors[0].figure.links[-1] == "bed", "parts lie on the bed"
    )
    person.until(lambda: person.colours() > 200, "the canvas shows something")
    assert "That did not work" not in person.text()


def choose(person: Any, what: str, wanted: str) -> None:
    """Choose from one of the lists."""
    person.page.get_by_role("combobox", name=what).click()
    person.page.get_by_role("option", name=wanted, exact=True).click()
