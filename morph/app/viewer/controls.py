"""The panel of a page: which view, its clock, its own knobs, what is told, what is kept."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from morph.app.viewer.charts import chart_html, now_html
from morph.app.viewer.downloads import keep_page, keep_view
from morph.app.viewer.fragments import keys_html, notes_html, table_html
from morph.app.viewer.style import style
from morph.app.viewer.transport import KEYS, ClockControls
from morph.app.viewer.view import View
from morph.app.viewer.widget import add_widget, hear_in_order, set_value

if TYPE_CHECKING:
    from morph.app.viewer.session import Session

KEEP = (
    "Turn the camera to all bodies; save one HTML file that opens without a network; or save a "
    "JSON file that `morph view --state` shows again."
)
"""What the buttons of the page do."""


class Controls:
    """The panel of one session; every method runs in the session's thread."""

    def __init__(self, session: Session) -> None:
        """Prepare; `build` adds it to the page."""
        self._session = session
        self.stale = False
        """Whether the picture must be shown anew though the clock stands."""
        self._transport: Any = None
        self._folder: Any = None
        self._told: Any = None
        self._now: Any = None
        self._loop: Any = None
        self._follow: Any = None
        self._fragments: list[Any] = []

    def build(self) -> None:
        """Add what every view has."""
        gui, session = self._session.client.gui, self._session
        hear_in_order(gui)
        self._look(dark=False)
        gui.main_panel.dock_right()
        gui.add_html(style())
        self._now = gui.add_html("")
        if len(session.views) > 1:
            names = tuple(view.title for view in session.views)
            given = (gui.add_button_group, "view", names)
            add_widget(session, *given, then=lambda name: self._turn(names.index(name)))
        self._transport = ClockControls(session)
        self._told = gui.add_folder("Shown")
        self._page(gui)

    def open_view(self) -> None:
        """Replace the last view's own controls by this one's."""
        gui = self._session.client.gui
        if self._folder is not None:
            self._folder.remove()
        self._folder = gui.add_folder(self._session.view.title, order=self._told.order - 0.5)
        with self._folder:
            self._session.view.panel(gui, self._session)
        # A view without controls of its own has no empty box for them.
        self._folder.visible = type(self._session.view).panel is not View.panel

    def show(self) -> None:
        """Show what belongs to the content: tables, charts, notes, the length of the clock."""
        session = self._session
        content, clock = session.content, session.clock
        self._transport.show(content)
        gui, notes = session.client.gui, (*session.opening.notes, *content.notes)
        fragments = [
            *(table_html(table, content.actors, clock.time) for table in content.tables),
            *(chart_html(chart, clock.seconds) for chart in content.charts),
            *([notes_html(notes)] if notes else []),
        ]
        # What is there is written anew: a browser that lags would be told of what was removed.
        for handle, html in zip(self._fragments, fragments, strict=False):
            if handle.content != html:
                handle.content = html
        for handle in self._fragments[len(fragments) :]:
            handle.remove()
        del self._fragments[len(fragments) :]
        with self._told:
            self._fragments += [gui.add_html(html) for html in fragments[len(self._fragments) :]]
        self._told.visible = bool(fragments)
        self.stale = True

    def tell(self) -> None:
        """Tell where the clock is."""
        session = self._session
        clock, content = session.clock, session.content
        self._transport.tell()
        self._now.content = now_html(clock.time, clock.seconds)
        for handle, table in zip(self._fragments, content.tables, strict=False):
            html = table_html(table, content.actors, clock.time)
            if handle.content != html:
                handle.content = html

    def resume(self) -> None:
        """Show what something else than a hand has set."""
        self._transport.resume()
        set_value(self._loop, self._session.clock.looping)
        set_value(self._follow, self._session.stage.following)

    def _page(self, gui: Any) -> None:
        """Add what belongs to the page rather than to a view; folded, for it is rarely used."""
        session = self._session
        with gui.add_folder("Page", expand_by_default=False):
            does: dict[str, Callable[[], None]] = {
                "See all": self._see,
                "Save page": partial(keep_page, session),
                "Save view": partial(keep_view, session),
            }
            add = partial(add_widget, session)
            add(
                gui.add_button_group,
                "actions",
                tuple(does),
                hint=KEEP,
                then=lambda action: does[action](),
            )
            self._follow = add(
                gui.add_checkbox,
                "follow",
                True,
                hint="Whether the camera goes with bodies that travel.",
                then=partial(setattr, session.stage, "following"),
            )
            looping = partial(setattr, session.clock, "looping")
            self._loop = add(gui.add_checkbox, "repeat", True, then=looping)
            add(gui.add_checkbox, "dark", False, then=lambda dark: self._look(dark=dark))
            gui.add_html(keys_html([*KEYS.values(), ("f", None, "see all")]))
        add(gui.add_command, "see all", hotkey="F", then=lambda _: self._see())

    def _turn(self, number: int) -> None:
        """Show another view; the one that is shown already stays as it is."""
        view = self._session.views[number]
        if view is not self._session.view:
            self._session.turn_to(view)

    def _see(self) -> None:
        self._session.stage.aim(self._session.client.camera)

    def _look(self, *, dark: bool) -> None:
        self._session.client.gui.configure_theme(
            show_logo=False, show_share_button=False, control_width="large", dark_mode=dark
        )
