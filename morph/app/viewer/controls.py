"""The knobs of a page: the clock's, the stage's, the choice of a view, and what is told."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from morph.app.viewer.clock import SPEEDS
from morph.app.viewer.charts import chart_html, now_html
from morph.app.viewer.fragments import notes_html, table_html
from morph.app.viewer.motion import RATE
from morph.app.viewer.style import style

if TYPE_CHECKING:
    from morph.app.viewer.session import Session

STEPS = {"-1 s": -1.0, "-1": -1.0 / RATE, "+1": 1.0 / RATE, "+1 s": 1.0}
"""The buttons that step, and by how much, s."""

KEYS = {
    "space": "play or pause",
    "arrowleft": "one picture back",
    "arrowright": "one picture on",
    "home": "to the start",
}
"""What the keys do."""


class Controls:
    """The knobs of one session; every method runs in the session's thread."""

    def __init__(self, session: Session) -> None:
        """Prepare; `build` adds them to the page."""
        self._session = session
        self.stale = False
        """Whether the picture must be shown anew though the clock stands."""
        self._play: Any = None
        self._slider: Any = None
        self._folder: Any = None
        self._told: Any = None
        self._now: Any = None
        self._tables: list[Any] = []
        self._charts: list[Any] = []

    def build(self) -> None:
        """Add what every view has."""
        gui, session = self._session.client.gui, self._session
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")
        gui.main_panel.dock_right()
        gui.add_html(style())
        self._now = gui.add_html("")
        if len(session.views) > 1:
            names = tuple(view.title for view in session.views)
            tabs = gui.add_button_group("view", names)
            self._on(tabs.on_click, lambda: session.turn_to(session.views[names.index(tabs.value)]))
        self._clock(gui)
        self._told = gui.add_folder("shown")
        for key, what in KEYS.items():
            command = gui.add_command(what, hotkey=key)
            self._on(command.on_trigger, partial(self._pressed, key))

    def open_view(self) -> None:
        """Replace the last view's own controls by this one's."""
        gui = self._session.client.gui
        if self._folder is not None:
            self._folder.remove()
        self._folder = gui.add_folder(self._session.view.title, order=self._told.order - 0.5)
        with self._folder:
            self._session.view.panel(gui, self._session)

    def show(self) -> None:
        """Show what belongs to the content: tables, charts, notes, the length of the clock."""
        session = self._session
        content, clock = session.content, session.clock
        self._slider.max = max(clock.seconds, 1.0 / RATE)
        for handle in (*self._tables, *self._charts):
            handle.remove()
        self._tables, self._charts = [], []
        gui = session.client.gui
        with self._told:
            for table in content.tables:
                self._tables.append(gui.add_html(table_html(table, content.actors, clock.time)))
            for chart in content.charts:
                self._charts.append(gui.add_html(chart_html(chart, clock.seconds)))
            if content.notes:
                self._charts.append(gui.add_html(notes_html(content.notes)))
        self.stale = True

    def tell(self) -> None:
        """Tell where the clock is."""
        session = self._session
        clock, content = session.clock, session.content
        self._slider.value = round(clock.time, 4)
        self._play.label = "Pause" if clock.playing else "Play"
        self._now.content = now_html(clock.time, clock.seconds)
        for handle, table in zip(self._tables, content.tables, strict=True):
            handle.content = table_html(table, content.actors, clock.time)

    def _clock(self, gui: Any) -> None:
        session, clock = self._session, self._session.clock
        self._play = gui.add_button("Pause")
        self._on(self._play.on_click, lambda: self._pressed("space"))
        steps = gui.add_button_group("step", tuple(STEPS))
        self._on(steps.on_click, lambda: clock.step(STEPS[steps.value]))
        self._slider = gui.add_slider("time (s)", 0.0, 1.0, 1e-3, 0.0)
        self._on(self._slider.on_update, lambda: session.jump(float(self._slider.value)))
        speed = gui.add_dropdown("speed", tuple(f"{each:g}" for each in SPEEDS), initial_value="1")
        self._on(speed.on_update, lambda: setattr(clock, "speed", float(speed.value)))
        loop = gui.add_checkbox("repeat", True)
        self._on(loop.on_update, lambda: setattr(clock, "looping", loop.value))
        follow = gui.add_checkbox("follow", True)
        self._on(follow.on_update, lambda: setattr(session.stage, "following", follow.value))

    def _pressed(self, key: str) -> None:
        clock = self._session.clock
        if key == "space":
            clock.toggle()
        elif key == "home":
            clock.seek(0.0)
        else:
            clock.step(STEPS["+1" if key == "arrowright" else "-1"])
        self.tell()

    def _on(self, event: Any, what: Callable[[], None]) -> None:
        """Have something done in the session's thread when a person does something.

        What the program sets by itself is no event.
        """

        def happened(event: Any) -> None:
            if event.client_id is not None:
                self._session.do(what)

        event(happened)
