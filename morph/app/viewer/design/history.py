"""What was done, to be undone and done again."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

State = TypeVar("State")

TOGETHER = 0.8
"""Changes of one thing that follow each other faster than this, s, are one step: a drag."""

MOST = 500
"""Steps that are kept."""


@dataclass(kw_only=True)
class History(Generic[State]):
    """The states that something was in, and which of them it is in now.

    It never asks what time it is: `change` is told.
    """

    now: State
    """The present state."""
    _past: list[State] = field(default_factory=list)
    _future: list[State] = field(default_factory=list)
    _last: tuple[str, float] | None = None

    def change(self, state: State, what: str, time: float) -> None:
        """Take a new state; all that was undone is forgotten.

        Args:
            state: The state; if it is the present one, nothing happened.
            what: What was changed, such as the name of a slider.
            time: When, s, on any clock. A change of what was changed last, soon after, makes
                one step with it.
        """
        if state == self.now:
            return
        before = self._last
        if before is None or before[0] != what or time - before[1] > TOGETHER:
            self._past = [*self._past, self.now][-MOST:]
        self.now, self._future, self._last = state, [], (what, time)

    def undo(self) -> bool:
        """Go back one step; return whether there was one."""
        if not self._past:
            return False
        self._future.append(self.now)
        self.now, self._last = self._past.pop(), None
        return True

    def redo(self) -> bool:
        """Go forward one step that was undone; return whether there was one."""
        if not self._future:
            return False
        self._past.append(self.now)
        self.now, self._last = self._future.pop(), None
        return True

    @property
    def steps(self) -> tuple[int, int]:
        """How many steps can be undone and done again."""
        return len(self._past), len(self._future)
