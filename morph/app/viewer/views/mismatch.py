"""Mismatch: the recording solid, the simulation as a ghost, and where they part."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from morph.app.viewer.content import Content
from morph.app.viewer.mismatch.case import MismatchCase
from morph.app.viewer.mismatch.choices import MismatchChoices
from morph.app.viewer.mismatch.load_case import load_case
from morph.app.viewer.mismatch.window import Take
from morph.app.viewer.mismatch.window_content import drawn
from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.arrays import JSON
from morph.errors import MorphError

if TYPE_CHECKING:
    from morph.app.viewer.session import Session


class Mismatch(View):
    """A recording and the simulation of it on one clock."""

    name: ClassVar[str] = "mismatch"
    title: ClassVar[str] = "Mismatch"

    def __init__(self, case: MismatchCase) -> None:
        """Begin with the first recording that no model had seen."""
        self._case, self._chosen = case, MismatchChoices.of(case)

    def content(self) -> Content:
        """Return the recording and its ghosts."""
        chosen = self._chosen
        return drawn(self._case, self._take(), chosen.shown, chosen.colouring)

    def state(self) -> JSON:
        """Return what is chosen."""
        return self._chosen.state(self._case)

    def restore(self, state: JSON) -> None:
        """Choose what an earlier `state` said.

        Raises:
            ViewError: It names a recording, a window, a model or a way that is not here.
        """
        self._chosen = MismatchChoices.restored(self._case, state)

    def panel(self, gui: Any, session: Session) -> None:
        """Add the choice of recording, window, simulation, models and colours, and findings."""
        from morph.app.viewer.mismatch.panel import MismatchPanel

        MismatchPanel(self, gui, session)

    @property
    def case(self) -> MismatchCase:
        """What was given."""
        return self._case

    @property
    def chosen(self) -> MismatchChoices:
        """What is shown."""
        return self._chosen

    def choose(self, chosen: MismatchChoices, session: Session, then: Callable[[], None]) -> None:
        """Show something else as soon as it is computed; what cannot be is not chosen.

        Args:
            chosen: What is to be shown.
            session: Whose page.
            then: Called in the session's thread when the choice holds, or holds no more.
        """
        before, self._chosen = self._chosen, chosen

        def computed() -> None:
            try:
                self._case.take(chosen.ask)
            except MorphError:
                session.do(undone)
                raise

        def undone() -> None:
            if self._chosen == chosen:
                self._chosen = before
            then()

        def shown(nothing: None) -> None:
            # Whoever chose again in the meantime waits for that alone.
            if self._chosen == chosen:
                session.show()
                then()

        session.later(computed, shown)

    def _take(self) -> Take:
        return self._case.take(self._chosen.ask)


def maker(given: ViewRequest) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page.

    Raises:
        MorphError: What was given cannot be used, or does not belong together.
    """
    case = load_case(given)
    # What is shown first is ready before anybody looks.
    case.take(MismatchChoices.of(case).ask)
    return partial(Mismatch, case)
