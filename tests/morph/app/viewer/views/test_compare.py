"""The view that compares bodies, and a person who turns its knobs, without a page."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from morph.app.viewer.clock import PlaybackClock
from morph.app.viewer.compare.panel import SWEEP
from morph.app.viewer.compare.shared_work import Work
from morph.app.viewer.compare.simulation_cache import Troupe
from morph.app.viewer.player import ARROWS
from morph.app.viewer.view_request import ViewRequest
from morph.app.viewer.views.compare import CompareView
from morph.body.load import load


def given(*names: str, **how: Any) -> ViewRequest:
    return ViewRequest(robots=tuple(map(load, names)), asked=names, **how)


class Handle:
    """What a page's knob is to those who use it."""

    def __init__(self, value: Any = None) -> None:
        self.value, self.content, self.visible = value, "", True
        self.changed: Callable[[Any], None] = lambda event: None
        self._impl = SimpleNamespace(sync_cb=None)

    def on_update(self, what: Callable[[Any], None]) -> None:
        self.changed = what

    def set(self, value: Any, by: int | None = 7) -> None:
        self.value = value
        if by is not None:
            self._impl.sync_cb(by, {"value": value})
        self.changed(SimpleNamespace(client_id=by))


class Gui:
    """A page that only remembers its knobs."""

    def __init__(self) -> None:
        self.knobs: dict[str, Handle] = {}

    def add_html(self, content: str) -> Handle:
        return self.knobs.setdefault(f"html {len(self.knobs)}", Handle())

    def add_dropdown(self, name: str, options: tuple[str, ...], initial_value: str) -> Handle:
        self.options = options
        return self.knobs.setdefault(name, Handle(initial_value))

    def add_checkbox(self, name: str, value: bool) -> Handle:
        return self.knobs.setdefault(name, Handle(value))


class Page:
    """A session that does at once what it is asked."""

    def __init__(self, view: CompareView) -> None:
        self.view, self.clock, self.shows = view, PlaybackClock(time=3.0, seconds=5.0), 0
        self.stage = SimpleNamespace(shown_arrows=set(ARROWS), reaim=lambda: None)
        self.client = SimpleNamespace(camera=None, atomic=nullcontext)

    def do(self, what: Callable[[], None]) -> None:
        what()

    def show(self) -> None:
        self.shows += 1
        self.content = self.view.content()


@pytest.fixture
def page() -> tuple[Page, Gui]:
    view = CompareView(Troupe(given("cartpole", "pendulum", seconds=0.5)))
    view.complete()
    page, gui = Page(view), Gui()
    page.show()
    view.panel(gui, page)  # type: ignore[arg-type]
    return page, gui


def test_a_person_may_turn_to_another_task_of_all_bodies(page: tuple[Page, Gui]) -> None:
    session, gui = page
    assert gui.options == (SWEEP, "balance", "swing-up")
    gui.knobs["task"].set("balance")
    assert session.clock.time == 0.0
    session.view.complete()
    assert session.view.state()["task"] == "balance"
    session.show()
    assert session.content.charts != ()
    gui.knobs["task"].set(SWEEP)
    assert session.view.state()["task"] is None
    assert session.content.charts == ()


def test_what_the_program_sets_by_itself_chooses_nothing(page: tuple[Page, Gui]) -> None:
    session, gui = page
    gui.knobs["task"].set("balance", by=None)
    assert session.view.state()["task"] is None


def test_the_boxes_say_which_arrows_are_drawn(page: tuple[Page, Gui]) -> None:
    session, gui = page
    assert "buoyancy" not in session.stage.shown_arrows
    # Those of other views are left alone.
    assert "wrench" in session.stage.shown_arrows
    gui.knobs["torque arrows"].set(False)
    gui.knobs["buoyancy arrows"].set(True)
    assert session.view.state()["arrows"] == ["buoyancy", "contact", "fluid"]
    assert {"torque", "buoyancy"} & session.stage.shown_arrows == {"buoyancy"}


def test_only_arrows_that_there_are_have_a_box() -> None:
    view = CompareView(Troupe(given("pendulum", task="balance", seconds=0.5)))
    view.complete()
    page, gui = Page(view), Gui()
    page.show()
    view.panel(gui, page)  # type: ignore[arg-type]
    # Without a policy the motor does nothing, and nothing touches anything.
    boxes = {name: knob.visible for name, knob in gui.knobs.items() if name.endswith("arrows")}
    assert not any(boxes.values())
    assert len(boxes) == 4
    assert "Goals: upright at hinge." in "".join(knob.content for knob in gui.knobs.values())
    assert "every command is zero" in "".join(knob.content for knob in gui.knobs.values())


def test_a_body_that_becomes_ready_is_shown_and_the_clock_begins_anew(
    page: tuple[Page, Gui], monkeypatch: pytest.MonkeyPatch
) -> None:
    session, _ = page
    late: Work[Any] = Work()
    ready = session.view._troupe.cast(None)
    monkeypatch.setattr(
        session.view._troupe,
        "cast",
        lambda name: SimpleNamespace(
            shows=(ready.shows[0], late), tasks=(), goals=(), done=1 + int(late.done)
        ),
    )
    session.show()
    session.view._listen(session)  # type: ignore[arg-type]
    assert session.content.actors[1].motion.pictures == 1
    before, session.clock.time = session.shows, 0.4
    late.end(ready.shows[1].found, None)
    assert session.shows == before + 1
    assert session.content.actors[1].motion.pictures == 31
    assert session.clock.time == 0.0
    assert np.isfinite(session.content.actors[1].motion.position).all()
