"""Long computations of which only the latest counts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

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
        self._next: tuple[Any, ...] | None = None

    @property
    def busy(self) -> bool:
        """Whether something is being done."""
        return self._busy

    def ask(
        self,
        session: Session,
        work: Callable[[], Any],
        then: Callable[[Any], None],
        otherwise: Callable[[], None] = lambda: None,
    ) -> None:
        """Have work done, and then in the session's thread what follows from it.

        Args:
            session: The page.
            work: What is done, in another thread.
            then: Given what it returned.
            otherwise: Done instead if it failed, which is told on the page.
        """
        if self._busy:
            self._next = (work, then, otherwise)
            return
        self._busy = True

        def tried() -> Any:
            try:
                return work()
            except Exception as error:
                # Told in the session's thread, where this is no longer busy.
                return error

        def over(result: Any) -> None:
            self._busy = False
            self.done += 1
            waiting, self._next = self._next, None
            if waiting is not None:
                self.ask(session, *waiting)
            if isinstance(result, Exception):
                otherwise()
                raise result
            then(result)

        session.later(tried, over)
