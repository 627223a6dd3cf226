"""Widgets of a page whose callbacks are registered before viser sends them."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from functools import partial
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from morph.app.viewer.session import Session


def add_widget(
    session: Session,
    add: Callable[..., Any],
    *values: Any,
    then: Callable[[Any], None],
    **props: Any,
) -> Any:
    """Return a widget that is added to the page and calls a function for each input of a user.

    viser sends a widget as soon as it is added, and drops inputs that arrive before a callback is
    registered. The atomic block holds the message back until one is. Values that the program
    sets call nothing.

    Args:
        session: Session of the page.
        add: Function of viser that adds the widget, such as `gui.add_slider`.
        *values: Positional arguments of `add`.
        then: Called in the session's thread with the input's value: True for a button, None for
            a key.
        **props: Keyword arguments of `add`.
    """
    inputs = _Inputs()

    def handle(value: Any) -> None:
        inputs.handled += 1
        then(value)

    def on_input(event: Any) -> None:
        if event.client_id is not None:
            inputs.arrived += 1
            # Not `widget.value`, which the program may have overwritten meanwhile.
            session.do(partial(handle, inputs.value))

    with session.client.atomic():
        widget = add(*values, **props)
        # viser calls `sync_cb` with a page's message just before the registered callbacks.
        widget._impl.sync_cb = inputs
        register = (getattr(widget, f"on_{name}", None) for name in ("update", "click", "trigger"))
        next(filter(None, register))(on_input)
    return widget


def set_value(widget: Any, value: Any) -> None:
    """Set the value of a widget, unless an input of the user is still queued.

    The queued input is newer, and its callback sets the value that follows from it.

    Args:
        widget: Widget of `add_widget`.
        value: Its new value.
    """
    inputs = widget._impl.sync_cb
    if inputs.handled == inputs.arrived:
        widget.value = value


class _Inputs:
    """Inputs of one widget: the last value, and how many arrived and were handled."""

    def __init__(self) -> None:
        self.value: Any = None
        # Each counter has a single writer: the connection's thread, and the session's.
        self.arrived, self.handled = 0, 0

    def __call__(self, client: int, updates: dict[str, Any]) -> None:
        self.value = updates.get("value", self.value)


def hear_in_order(gui: Any) -> None:
    """Make viser run the callbacks of a page in the order of its inputs.

    By default viser runs each callback in a thread of a pool, where the next input may overtake
    it or have replaced its value.

    Args:
        gui: The `viser.GuiApi` of one page; all its callbacks are those of `add_widget`, which
            only put a call into a queue.
    """
    gui._thread_executor = _InlineExecutor()


class _InlineExecutor(Executor):
    """Runs each call inside `submit`."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future
