"""A page of the view Design without a browser: its controls are kept, and moved by tests."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest

from morph.app.viewer.content import Content
from morph.app.viewer.views.design import DesignView

HAND = SimpleNamespace(client_id=1)
"""An event that a person caused."""


class Knob:
    """A control of the page."""

    def __init__(self, kind: str, label: str, page: Page, **props: Any) -> None:
        self.__dict__.update(props, kind=kind, label=label, page=page, visible=True)
        self._impl = SimpleNamespace(uuid=f"number {len(page.knobs)}", sync_cb=None)
        self._told: list[Callable[[Any], None]] = []

    def on_update(self, what: Callable[[Any], None]) -> None:
        self._told.append(what)

    on_click = on_update
    on_trigger = on_update

    def move(self, value: Any = None) -> None:
        """Be moved by a hand."""
        if value is not None:
            self.value = value
        if self._impl.sync_cb is not None:
            self._impl.sync_cb(1, {"value": getattr(self, "value", None)})
        for told in self._told:
            told(HAND)

    def remove(self) -> None:
        self.page.knobs = [
            knob for knob in self.page.knobs if knob is not self and knob.inside is not self
        ]

    def __enter__(self) -> None:
        self.before, self.page.inside = self.page.inside, self

    def __exit__(self, *_: object) -> None:
        self.page.inside = self.before


class Page:
    """A page and its session: what is done later is done when a test says so."""

    def __init__(self, view: DesignView) -> None:
        self.knobs: list[Any] = []
        self.inside: Any = None
        self.said: list[str] = []
        self.jobs: list[tuple[Callable[[], Any], Callable[[Any], None]]] = []
        self.chosen: list[tuple[int, str | None]] = []
        self.shown = 0
        self.view = view
        self.content = Content(actors=())
        self.client = SimpleNamespace(camera=None, atomic=nullcontext)
        self.stage = SimpleNamespace(
            choose=lambda *which: self.chosen.append(which), aim=lambda _: None, picked=None
        )

    def __getattr__(self, name: str) -> Any:
        """Add any kind of control, as viser's `add_...` do."""

        def add(label: Any = "", *values: Any, **props: Any) -> Knob:
            props.pop("visible", None)
            value = {"slider": -1, "text": 0, "checkbox": 0}.get(name.removeprefix("add_"))
            given = values[value] if value is not None else props.get("initial_value", "")
            if name == "add_slider":
                props |= {"min": values[0], "max": values[1]}
            knob = Knob(name.removeprefix("add_"), label, self, value=given, **props)
            knob.inside = self.inside
            self.knobs.append(knob)
            return knob

        if name.startswith("add_"):
            return add
        raise AttributeError(name)

    def do(self, what: Callable[[], None]) -> None:
        what()

    def later(self, work: Callable[[], Any], then: Callable[[Any], None]) -> None:
        self.jobs.append((work, then))

    def show(self, content: Content, *, still: bool = False) -> None:
        self.content, self.shown = content, self.shown + 1

    def say(self, text: str, *, bad: bool = False) -> None:
        self.said.append(text)

    def work(self) -> None:
        """Do all that was put off."""
        while self.jobs:
            work, then = self.jobs.pop(0)
            then(work())

    def knob(self, label: str, kind: str | None = None) -> Any:
        found = [each for each in self.knobs if each.label == label and kind in (None, each.kind)]
        assert len(found) == 1, (label, [each.label for each in self.knobs])
        return found[0]

    def press(self, label: str) -> None:
        group = next(
            each for each in self.knobs if each.kind == "button_group" and label in each.options
        )
        group.move(label)

    def cell(self, row: str, column: int) -> str:
        rows = {str(each[0]): each for each in self.content.tables[0].rows}
        return str(rows[row][column])


def opened_by(view: DesignView) -> Page:
    """Return the page of a person who has opened it."""
    page = Page(view)
    # A button group's choices are given by position; everything else by name.
    plain = page.__getattr__
    page.add_button_group = lambda label, options: plain("add_button_group")(  # type: ignore[attr-defined]
        label, options=options
    )
    page.add_dropdown = lambda label, options, initial_value=None: plain("add_dropdown")(  # type: ignore[attr-defined]
        label, options=options, initial_value=initial_value or options[0]
    )
    view.panel(page, page)  # type: ignore[arg-type]
    page.content = view.content()
    return page


@pytest.fixture
def opened() -> Callable[[DesignView], Any]:
    """Opens a page."""
    return opened_by
