"""Long work of which only the latest counts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from morph.errors import MorphError

if TYPE_CHECKING:
    from morph.app.viewer.session import Session


class Latest:
    """One thing at a time beside the session; of what is asked meanwhile, the last is done next.

    A hand on a slider asks for a hundred bodies, and only some of them are ever built.
    """

    def __init__(self) -> None:
        """Begin idle."""
        self.done = 0
        """How many works were done."""
        self._busy = False
        self._next: tuple[Callable[[], Any], Callable[[Any], None]] | None = None

    @property
    def busy(self) -> bool:
        """Whether something is being done."""
        return self._busy

    def ask(self, session: Session, work: Callable[[], Any], then: Callable[[Any], None]) -> None:
        """Have work done, and what comes of it, in the session's thread; an error is told."""
        if self._busy:
            self._next = (work, then)
            return
        self._busy = True

        def tried() -> Any:
            try:
                return work()
            except MorphError as error:
                return error

        def over(found: Any) -> None:
            self._busy = False
            self.done += 1
            if isinstance(found, MorphError):
                session.say(f"{found.where}: {found.what}. {found.fix}", bad=True)
            else:
                then(found)
            if self._next is not None and not self._busy:
                waiting, self._next = self._next, None
                self.ask(session, *waiting)

        session.later(tried, over)
