"""When a search has to end."""

from __future__ import annotations

import math
import threading
import time
from dataclasses import dataclass, field, replace


@dataclass(frozen=True, kw_only=True)
class Deadline:
    """A time by which a search ends, or as soon as it is interrupted."""

    time: float = math.inf
    """Of the monotonic clock, s."""
    interrupt: threading.Event = field(default_factory=threading.Event)
    """Set to end it now; earlier deadlines of the same search share it."""

    @property
    def passed(self) -> bool:
        """Whether no further step may begin."""
        return self.left <= 0.0

    @property
    def left(self) -> float:
        """Seconds that are left, 0 or less once it has passed."""
        return 0.0 if self.interrupt.is_set() else self.time - time.monotonic()

    def earlier(self, seconds: float) -> Deadline:
        """Return one that is earlier by some seconds."""
        return replace(self, time=self.time - seconds)

    def within(self, seconds: float) -> Deadline:
        """Return one that is at most some seconds from now."""
        return replace(self, time=min(self.time, time.monotonic() + seconds))

    def halfway(self, since: float | None = None) -> Deadline:
        """Return one in the middle of the time since some time, by default now, until this one."""
        begun = time.monotonic() if since is None else since
        return replace(self, time=0.5 * (self.time + begun))


NEVER = Deadline()
"""No end."""
