"""Print: the parts of a body, taken apart or on their plates, and what was found of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from morph.app.viewer.content import Content
from morph.app.viewer.printed.choices import APART, PrintChoices, choices_of
from morph.app.viewer.printed.package_cache import Works
from morph.app.viewer.printed.package_content import notes, tables
from morph.app.viewer.printed.panel import PrintPanel, panel
from morph.app.viewer.printed.source import divided, packed
from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.arrays import JSON

if TYPE_CHECKING:
    from morph.app.viewer.session import Session

BEING_MADE = "Its parts are being made and looked at; that takes some seconds."
"""What is said until there are any."""


class PrintView(View):
    """The parts of one body.

    Args:
        works: What all persons share.
    """

    name: ClassVar[str] = "print"
    title: ClassVar[str] = "Print"

    def __init__(self, works: Works) -> None:
        """Begin with the body that comes apart."""
        self.works, self.chosen = works, PrintChoices()
        self._panel: PrintPanel | None = None

    def content(self) -> Content:
        """Return the parts; until they are made, the body as it is described."""
        made = self.works.made
        if made is None:
            note = self.works.excuse or BEING_MADE
            return Content(actors=(self.works.described,), notes=(note,), title="parts")
        chosen = self.shown(self.chosen)
        actors, moments = made.actors(chosen)
        return Content(
            actors=actors,
            moments=moments,
            tables=tables(made, chosen),
            notes=tuple(notes(made)),
            title=f"parts of {made.package.title}",
        )

    def complete(self) -> None:
        """Wait until parts and their colours are there."""
        self.works.complete(self.chosen.by)

    def panel(self, gui: Any, session: Session) -> None:
        """Add its knobs, and have made what is missing."""
        self._panel = panel(self, gui, session)
        if not self.works.has(self.chosen.by):
            self.choose(self.chosen, session)

    def picture(self, time: float) -> None:
        """Have the slider follow the clock."""
        if self._panel is not None:
            self._panel.tell(time)

    def state(self) -> JSON:
        """Return what is chosen."""
        return self.chosen.said()

    def restore(self, state: JSON) -> None:
        """Choose what an earlier `state` said."""
        self.chosen = choices_of(state)

    def shown(self, chosen: PrintChoices) -> PrintChoices:
        """Return what of a choice there is: a saved view may name a plate that is no more."""
        made = self.works.made
        known = made is not None and chosen.show in made.ways
        return chosen if known else replace(chosen, show=APART)

    def choose(self, chosen: PrintChoices, session: Session) -> None:
        """Show something else as soon as it is made."""
        self.chosen = chosen
        if self.works.has(chosen.by):
            session.show()
            return

        def shown(nothing: None) -> None:
            # Whoever chose again, or went to another view, does not want this.
            if self.chosen == chosen and session.view is self:
                session.show()
                if self._panel is not None:
                    self._panel.refresh()
                session.stage.reaim()

        session.later(partial(self.works.complete, chosen.by), shown)


def maker(given: ViewRequest) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page.

    Raises:
        MorphError: The package cannot be used.
    """
    if given.package is not None:
        robot, package = packed(given.package)
        works = Works(robot, lambda: package)
        # What is shown first is there when the first person comes.
        works.complete()
    else:
        body = given.robots[0]
        works = Works(body, partial(divided, body))
    return partial(PrintView, works)
