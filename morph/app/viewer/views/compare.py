"""Compare: bodies side by side on one ground, in the same task, on one clock."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from morph.app.viewer.compare.arrows import KINDS
from morph.app.viewer.compare.compare_content import lengths, told
from morph.app.viewer.compare.panel import ComparePanel
from morph.app.viewer.compare.simulation_cache import Cast, Troupe
from morph.app.viewer.content import Content
from morph.app.viewer.player import CONSTANT
from morph.app.viewer.view import View
from morph.app.viewer.view_request import ViewRequest
from morph.arrays import JSON
from morph.errors import ViewError

if TYPE_CHECKING:
    from morph.app.viewer.session import Session

SHOWN = set(KINDS) - {CONSTANT}
"""The arrows that are shown at first."""


class CompareView(View):
    """Up to eight bodies at once, each with its policy, or each showing its joints."""

    name: ClassVar[str] = "compare"
    title: ClassVar[str] = "Compare"

    def __init__(self, troupe: Troupe) -> None:
        """Begin with the task that was asked for."""
        self._troupe = troupe
        self._task = troupe.task
        self._arrows = set(SHOWN)
        self._panel: ComparePanel | None = None
        self._shown = 0

    def content(self) -> Content:
        """Return the bodies, those at rest that are not ready, and the table that compares them."""
        cast = self._cast
        self._shown = cast.done
        return told(self._task, self._troupe.rest, cast.shows)

    def complete(self) -> None:
        """Wait until every body is ready."""
        for work in self._cast.shows:
            work.wait()

    def panel(self, gui: Any, session: Session) -> None:
        """Add the choice of a task and of arrows; and tell what commands each body."""
        self._panel = ComparePanel(
            gui,
            session,
            self._troupe.tasks,
            self._task,
            self._arrows,
            on_task=partial(self._turn, session),
            on_arrows=partial(self._draw, session),
        )
        self._draw(session, self._arrows)
        self._listen(session)

    @property
    def arrows(self) -> set[str]:
        """The kinds of arrows that are drawn."""
        return set(self._arrows)

    def state(self) -> JSON:
        """Return the task and the arrows that are shown."""
        return {"task": self._task, "arrows": sorted(self._arrows)}

    def restore(self, state: JSON) -> None:
        """Choose what an earlier `state` said.

        Raises:
            ViewError: It is of other bodies, or of another view.
        """
        if strange := sorted(set(state) - set(self.state())):
            raise ViewError(
                f"the state holds {strange[0]!r}, which says nothing here",
                where="the view compare",
                fix=f"keep {' and '.join(self.state())} of it",
            )
        task, arrows = state.get("task", self._task), state.get("arrows", sorted(SHOWN))
        if task is not None and task not in self._troupe.tasks:
            raise ViewError(
                f"the state speaks of a task {task!r} that these bodies do not share",
                where="the view compare",
                fix=f"choose one of {', '.join(self._troupe.tasks) or 'none'}",
            )
        if not isinstance(arrows, list) or not set(map(str, arrows)) <= set(KINDS):
            raise ViewError(
                f"the state speaks of arrows {arrows!r}",
                where="the view compare",
                fix=f"name some of {', '.join(KINDS)}",
            )
        self._task, self._arrows = task, set(arrows)

    @property
    def _cast(self) -> Cast:
        return self._troupe.cast(self._task)

    def _turn(self, session: Session, task: str | None) -> None:
        """Show another task; what is computed for it comes when it is ready."""
        if task == self._task:
            return
        self._task = task
        session.clock.seek(0.0)
        session.show()
        self._listen(session)

    def _draw(self, session: Session, kinds: set[str]) -> None:
        self._arrows = set(kinds)
        session.stage.shown_arrows -= set(KINDS)
        session.stage.shown_arrows |= self._arrows

    def _listen(self, session: Session) -> None:
        """Hear of what is still being computed, and tell how it stands."""
        for work in self._cast.shows:
            work.listen(lambda: session.do(partial(self._hear, session)))
        self._hear(session)

    def _hear(self, session: Session) -> None:
        if session.view is not self or self._panel is None:
            return
        cast = self._cast
        self._panel.tell(self._troupe.names, cast.shows, lengths(cast.shows), cast.goals)
        if cast.done > self._shown:
            session.show()
            if cast.done == len(cast.shows):
                # Now that all move they take other room, and begin together.
                session.clock.seek(0.0)
                session.stage.reaim()


def maker(given: ViewRequest) -> Callable[[], View]:
    """Return what makes this view for a person who opens the page.

    Raises:
        MorphError: A policy, the task or the world cannot be used by these bodies.
    """
    troupe = Troupe(given)
    return lambda: CompareView(troupe)
