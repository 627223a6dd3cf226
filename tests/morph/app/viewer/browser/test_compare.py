"""Bodies compared in a real browser: a task is chosen, arrows are hidden, the clock is moved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from morph.app.viewer.compare.panel import SWEEP


def test_bodies_turn_to_a_task_that_all_of_them_know_and_tell_what_it_cost(
    served: Callable[..., Any], look: Callable[..., Any]
) -> None:
    viewer = served("quadruped_four_bar", "quadruped_printed", seconds=0.5)
    person = look(viewer.address)
    person.until(lambda: "holding margin" in person.text(), "joints go through their ranges")
    (session,) = viewer.sessions
    chosen = person.page.get_by_role("combobox", name="task")
    assert chosen.input_value() == SWEEP
    chosen.click()
    person.page.get_by_role("option", name="walk").click()
    person.until(lambda: "Energy so far" in person.text(), "both have been simulated")
    person.until(
        lambda: session.content.seconds == 0.5 and len(session.content.charts) == 2,
        "the page's session shows what its panel tells",
    )
    text = person.text()
    assert "quadruped_four_bar: no policy: every command is zero" in text
    assert "contact: half the body's size is" in text
    session.do(lambda: session.jump(0.25))
    drawn = person.settled()
    # Four feet each stand on the ground: that is seen, and gone with the box.
    person.page.get_by_label("contact arrows").click()
    person.until(lambda: person.changes(drawn), "the arrows are gone")
    assert "contact" in session.stage.hidden_arrows
    assert session.view.state() == {"task": "walk", "arrows": ["fluid", "torque"]}
