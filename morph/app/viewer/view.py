"""The family of views: each says what is shown, and has controls of its own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection
from typing import TYPE_CHECKING, Any, ClassVar

from morph.app.viewer.content import Content
from morph.arrays import JSON

if TYPE_CHECKING:
    from morph.app.viewer.session import Session


class View(ABC):
    """One way of looking at bodies; every person has one of their own.

    All methods are called in the session's own thread, so that a view needs no lock. What
    takes longer than a picture is handed to `session.later`.
    """

    name: ClassVar[str]
    """What files and the command line call it: `compare`."""
    title: ClassVar[str]
    """What its tab is called."""

    @abstractmethod
    def content(self) -> Content:
        """Return what is shown now; at once, even if more is still being computed."""

    def complete(self) -> None:
        """Wait until nothing that is still being computed is missing from `content`.

        What is exported or pictured waits for it, without a page; a page never does. What can
        be shown without what failed is shown.

        Raises:
            MorphError: Nothing of it can be shown.
        """

    @property
    def arrows(self) -> Collection[str] | None:
        """Kinds of arrows that are drawn; None for all that there are."""
        return None

    def panel(self, gui: Any, session: Session) -> None:
        """Add its controls to the page; they act through `session.do` and `session.show`.

        Args:
            gui: The `viser.GuiApi` of this person's page, inside the view's folder.
            session: The page.
        """

    def picture(self, time: float) -> None:
        """Be told that the clock's picture at a time, s, is shown, some times a second."""

    def state(self) -> JSON:
        """Return what is chosen, as JSON: enough to show the same again by `restore`."""
        return {}

    def restore(self, state: JSON) -> None:
        """Choose what an earlier `state` said; called before `content`.

        Raises:
            ViewError: The state is of another view, or does not fit what is shown.
        """
