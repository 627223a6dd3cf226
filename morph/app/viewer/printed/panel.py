"""The knobs of the view: what is shown, how far apart, what colours tell, and the download."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from morph.app.viewer.printed.choices import APART, COLOURINGS, PrintChoices
from morph.app.viewer.printed.figures import how_far, part_of, when
from morph.app.viewer.printed.package_zip import zipped
from morph.app.viewer.widget import add_widget, set_value

if TYPE_CHECKING:
    from morph.app.viewer.session import Session
    from morph.app.viewer.views.print import PrintView

NONE = "none"
"""What is chosen where no part is pointed at."""

HAND = 0.5
"""The slider is left to the hand that moved it for so long, s."""


class PrintPanel:
    """The knobs of one person's page; what they do, they do in the session's thread.

    Args:
        view: What they choose for.
        gui: The page's `viser.GuiApi`.
        session: The page.
    """

    def __init__(self, view: PrintView, gui: Any, session: Session) -> None:
        """Add them."""
        self._view, self._session = view, session
        self._touched, self._packing = 0.0, False
        chosen = view.chosen
        self._show = self._list(gui, "show", [chosen.show], self._to_show)
        self._apart = add_widget(
            session, gui.add_slider, "apart (%)", 0, 100, 1, 0, then=self._to_apart
        )
        self._by = self._list(gui, "colours", COLOURINGS, self._to_by)
        self._part = self._list(gui, "point at", [NONE], self._to_part)
        self._load = add_widget(
            session,
            gui.add_button,
            "Download package",
            icon="download",
            visible=False,
            then=self._download,
        )
        self.refresh()

    def refresh(self) -> None:
        """Let every list hold what there is now, and show what is chosen of it."""
        chosen, made = self._view.chosen, self._view.works.made
        ways = (APART,) if made is None else made.ways
        parts = () if made is None else tuple(made.skins)
        for handle, options, value in (
            (self._show, ways, self._view.shown(chosen).show),
            (self._by, COLOURINGS, chosen.by),
            (self._part, (NONE, *parts), chosen.part if chosen.part in parts else NONE),
        ):
            if tuple(handle.options) != tuple(options):
                handle.options = tuple(options)
            if handle.value != value:
                set_value(handle, value)
        self._apart.visible = made is not None and self._view.shown(chosen).show == APART
        self._load.visible = made is not None and made.package.folder is not None

    def tell(self, now: float) -> None:
        """Show how far apart the body is, unless a hand is on it."""
        if self._apart.visible and time.monotonic() - self._touched > HAND:
            percent = round(100.0 * how_far(now))
            if self._apart.value != percent:
                set_value(self._apart, percent)

    def point(self, part: str) -> None:
        """Point at a part; at the same once more: at none."""
        self._to(replace(self._view.chosen, part="" if part == self._view.chosen.part else part))

    def _list(
        self, gui: Any, label: str, options: Sequence[str], then: Callable[[str], None]
    ) -> Any:
        given = (gui.add_dropdown, label, tuple(options))
        return add_widget(self._session, *given, then=then, initial_value=options[0])

    def _to(self, chosen: PrintChoices) -> None:
        before = self._view.chosen
        self._view.choose(chosen, self._session)
        self.refresh()
        if before.show != chosen.show:
            self._session.clock.seek(0.0)

    def _to_show(self, show: str) -> None:
        self._to(replace(self._view.chosen, show=show))
        # A plate has another shape than the body: all of it is to be seen.
        self._session.stage.aim(self._session.client.camera)

    def _to_by(self, by: str) -> None:
        self._to(replace(self._view.chosen, by=by))

    def _to_part(self, part: str) -> None:
        self._to(replace(self._view.chosen, part="" if part == NONE else part))

    def _to_apart(self, percent: int) -> None:
        self._touched = time.monotonic()
        self._session.jump(when(0.01 * percent))

    def _download(self, _: bool) -> None:
        made = self._view.works.made
        folder = None if made is None else made.package.folder
        if made is None or folder is None or self._packing:
            return
        self._packing = True
        name = made.package.name

        def work() -> bytes:
            try:
                return zipped(folder, name)
            finally:
                self._packing = False

        def done(packed: bytes) -> None:
            self._session.client.send_file_download(f"{name}.zip", packed, save_immediately=True)
            self._session.say(f"{name}.zip is saved: {len(packed) / 1e6:.1f} MB.")

        self._session.later(work, done)


def panel(view: PrintView, gui: Any, session: Session) -> PrintPanel:
    """Add the knobs, and let a click on a part point at it."""
    knobs = PrintPanel(view, gui, session)

    def picked(actor: int, link: str) -> None:
        session.do(lambda: knobs.point(part_of(link)))

    session.stage.picked = picked
    return knobs
