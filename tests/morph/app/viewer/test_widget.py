"""Widgets listen before they are sent, and hear of every input in order with its own value."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest

from morph.app.viewer.session import Session
from morph.app.viewer.view import View
from morph.app.viewer.widget import add_widget, set_value


class Slider:
    """A widget of a page that a test moves; `told` hears of it."""

    def __init__(self, value: float) -> None:
        self.value = value
        self._impl = SimpleNamespace(sync_cb=None)

    def on_update(self, told: Callable[[Any], None]) -> None:
        self.told = told

    def move(self, value: float, by: int | None = 7, *, written: float | None = None) -> None:
        """Have a page, or the program, say a value; before that is heard, `written` is set."""
        self.value = value
        if by is not None:
            self._impl.sync_cb(by, {"value": value})
        if written is not None:
            self.value = written
        self.told(SimpleNamespace(client_id=by))


def page() -> tuple[Any, list[Callable[[], None]]]:
    """A session that does what it is asked when a test says so."""
    asked: list[Callable[[], None]] = []
    return SimpleNamespace(client=SimpleNamespace(atomic=nullcontext), do=asked.append), asked


def test_an_input_keeps_its_value_though_the_program_writes_before_it_is_acted_on() -> None:
    session, asked = page()
    acted: list[float] = []
    slider = add_widget(session, Slider, 1.0, then=acted.append)
    slider.move(2.0)
    slider.value = 1.0
    slider.move(3.0, written=1.0)
    for act in asked:
        act()
    assert acted == [2.0, 3.0]


def test_of_two_inputs_both_are_acted_on_and_the_page_keeps_the_last() -> None:
    session, asked = page()
    acted: list[float] = []
    slider = add_widget(session, Slider, 1.0, then=acted.append)
    slider.move(2.0)
    slider.move(3.0)
    asked[0]()
    assert (acted, slider.value) == ([2.0], 3.0)
    asked[1]()
    assert (acted, slider.value) == ([2.0, 3.0], 3.0)


def test_what_was_typed_is_not_overwritten_while_it_waits() -> None:
    session, asked = page()
    slider = add_widget(session, Slider, 1.0, then=lambda _: None)
    slider.move(2.0)
    set_value(slider, 1.0)
    assert slider.value == 2.0
    asked[0]()
    set_value(slider, 1.0)
    assert slider.value == 1.0


def test_what_the_program_sets_is_no_input() -> None:
    session, asked = page()
    add_widget(session, Slider, 1.0, then=pytest.fail).move(2.0, by=None)
    assert asked == []


def test_no_widget_of_any_view_is_sent_before_somebody_listens(
    monkeypatch: pytest.MonkeyPatch,
    viewer: Any,
    people: Callable[..., Any],
    waits: Callable[..., Any],
) -> None:
    from viser import _messages
    from viser.infra._async_message_buffer import AsyncMessageBuffer

    kinds = ("Slider", "Dropdown", "Checkbox", "Button", "ButtonGroup", "Text")
    widgets = tuple(getattr(_messages, f"Gui{kind}Message") for kind in kinds)
    widgets += (_messages.RegisterCommandMessage,)
    pushed: list[Any] = []
    deaf: list[str] = []
    push, end = AsyncMessageBuffer.push, AsyncMessageBuffer.atomic_end

    def pushes(buffer: Any, message: Any) -> None:
        if isinstance(message, widgets):
            pushed.append(message)
            # Outside an atomic block it may be sent at once.
            if buffer.atomic_counter == 0:
                deaf.append(message.props.label)
        push(buffer, message)

    def ends(buffer: Any) -> None:
        # Whoever ends the block has it sent.
        gui = next((each.client.gui for each in viewer.sessions), None)
        for message in pushed if buffer.atomic_counter == 1 and gui is not None else ():
            deaf.extend([message.props.label] if not listened(gui, message.uuid) else [])
        end(buffer)

    monkeypatch.setattr(AsyncMessageBuffer, "push", pushes)
    monkeypatch.setattr(AsyncMessageBuffer, "atomic_end", ends)
    people(viewer.door.server.get_port()).enters()
    waits(lambda: viewer.sessions and viewer.sessions[0].content.actors)
    # What every page has: 1 button, 2 groups, 1 slider, 2 choices, 3 boxes and 10 keys.
    assert len(pushed) == 19
    assert deaf == []


def listened(gui: Any, number: str) -> bool:
    """Whether somebody listens to a widget or a key."""
    widget = gui._gui_input_handle_from_uuid.get(number)
    if widget is not None:
        return bool(widget._impl.update_cb)
    key = gui._command_handle_from_uuid.get(number)
    return key is not None and bool(key._impl.trigger_cb)


class Fast(View):
    """A view that notes the inputs that it hears of."""

    name, title = "fast", "Fast"

    def panel(self, gui: Any, session: Session) -> None:
        self.heard: list[float] = []
        self.slider = add_widget(
            session, gui.add_slider, "fast", 0.0, 999.0, 1.0, 0.0, then=self.heard.append
        )


def test_inputs_are_heard_of_in_the_order_in_which_they_come(
    still: type[View], people: Callable[..., Any], waits: Callable[..., Any]
) -> None:
    from morph.app.viewer.server import Viewer

    viewer = Viewer(lambda: [type("Both", (Fast, still), {})()], port=0)
    person = people(viewer.door.server.get_port()).enters()
    number = person.hears("GuiSliderMessage", "fast")["uuid"]
    for value in range(1, 300):
        person.says(type="GuiUpdateMessage", uuid=number, updates={"value": float(value)})
    heard = viewer.sessions[0].view.heard
    waits(lambda: len(heard) == 299)
    viewer.close()
    assert heard == [float(value) for value in range(1, 300)]
