"""The knobs of the view: which hop, which lines, which part, and what moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from morph.app.viewer.align.choices import SORTS
from morph.app.viewer.widget import add_widget, set_value

if TYPE_CHECKING:
    from morph.app.viewer.align.choices import AlignChoices
    from morph.app.viewer.session import Session
    from morph.app.viewer.views.align import AlignView

WHOLE, ALL, NONE = "the whole chain", "all", "nothing"
"""What is chosen where no single hop, part or motion is."""


class AlignPanel:
    """The knobs of one person's page; what they do, they do in the session's thread.

    Args:
        view: What they choose for.
        gui: The page's `viser.GuiApi`.
        session: The page.
    """

    def __init__(self, view: AlignView, gui: Any, session: Session) -> None:
        """Add them."""
        self._view, self._session = view, session
        self._hops = [WHOLE, *view.hops]
        if len(view.hops) > 1:
            self._list(gui, "hop", self._hops, view.chosen.hop, self._to_hop)
        at = SORTS.index(view.chosen.sort)
        self._list(gui, "lines", SORTS, at, self._to_sort)
        self._part = self._list(gui, "part", self._parts(), 0, self._to_part)
        self._way = self._list(gui, "motion", self._ways(), 0, self._to_way)
        add_widget(
            session, gui.add_checkbox, "enlarge motion", view.chosen.large, then=self._to_large
        )
        self._refresh()

    def point(self, part: str) -> None:
        """Point at a part, or at none by an empty text, as if it were chosen from the list."""
        self._to(replace(self._view.chosen, part=part))

    def _list(
        self, gui: Any, label: str, options: Sequence[str], at: int, then: Callable[[str], None]
    ) -> Any:
        given = (gui.add_dropdown, label, tuple(options))
        return add_widget(self._session, *given, then=then, initial_value=options[at])

    def _parts(self) -> list[str]:
        return [ALL, *self._view.labels]

    def _ways(self) -> list[str]:
        return [*self._view.ways, NONE]

    def _to(self, chosen: AlignChoices) -> None:
        """Choose, compute the motion beside the page, and show it when it is there."""
        self._view.chosen = chosen
        self._refresh()
        self._session.later(self._view.complete, lambda _: self._shown(chosen))

    def _shown(self, chosen: AlignChoices) -> None:
        # Whoever chose something else meanwhile, or went to another view, does not want this.
        if self._view.chosen == chosen and self._session.view is self._view:
            self._session.show()

    def _refresh(self) -> None:
        """Let every list hold what there is now, and show what is chosen of it."""
        chosen = self._view.chosen
        for handle, options, value in (
            (self._part, self._parts(), chosen.part or ALL),
            (self._way, self._ways(), chosen.way or NONE),
        ):
            if handle.options != tuple(options):
                handle.options = tuple(options)
            if handle.value != value:
                set_value(handle, value)

    def _to_hop(self, hop: str) -> None:
        self._to(self._view.at_hop(self._hops.index(hop)))
        self._session.clock.seek(0.0)

    def _to_sort(self, sort: str) -> None:
        self._to(replace(self._view.chosen, sort=sort, part=""))

    def _to_part(self, part: str) -> None:
        self.point("" if part == ALL else part)

    def _to_way(self, way: str) -> None:
        self._to(replace(self._view.chosen, way="" if way == NONE else way))
        self._session.clock.seek(0.0)

    def _to_large(self, large: bool) -> None:
        self._to(replace(self._view.chosen, large=large))


def panel(view: AlignView, gui: Any, session: Session) -> None:
    """Add the knobs, and let a click on a link point at its part."""
    knobs = AlignPanel(view, gui, session)

    def picked(actor: int, link: str) -> None:
        session.do(lambda: knobs.point(view.part_at(actor, link)))

    session.stage.picked = picked
