"""The clock that all bodies on one page share."""

from __future__ import annotations

from dataclasses import dataclass

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
"""How fast it may run, by how fast time passes."""

REST = 0.5
"""How long it rests at the end before it begins again, s."""


@dataclass(kw_only=True)
class PlaybackClock:
    """A time from 0 to the end that plays, pauses, steps and is scrubbed.

    It never asks what time it is: `tick` is told how much has passed, so that tests and
    exports run it as they like.
    """

    seconds: float = 0.0
    """Where it ends, s."""
    time: float = 0.0
    """Where it is, s."""
    playing: bool = True
    """Whether it runs."""
    speed: float = 1.0
    """How fast, one of `SPEEDS`."""
    looping: bool = True
    """Whether it begins again after the end; if not, it stops there."""
    rested: float = 0.0
    """How long it has rested at the end, s of real time."""

    def tick(self, passed: float) -> None:
        """Let real time pass, s, 0 or more."""
        if not self.playing or self.seconds <= 0.0:
            return
        if self.time < self.seconds:
            self.time = min(self.seconds, self.time + passed * self.speed)
            self.rested = 0.0
            if self.time >= self.seconds and not self.looping:
                self.playing = False
            return
        self.rested += passed
        if self.rested >= REST:
            self.time, self.rested = 0.0, 0.0

    def due(self, rate: float) -> float:
        """Return in how much real time the next of so many pictures a second is due, s.

        At most the time of one picture, which is also given where the clock stands.
        """
        if not self.playing or self.time >= self.seconds:
            return 1.0 / rate
        after = (int(self.time * rate + 1e-6) + 1) / rate - self.time
        return min(after / self.speed, 1.0 / rate)

    def seek(self, time: float) -> None:
        """Go to a time, s; outside the clock's range the nearest end is taken."""
        self.time, self.rested = min(max(time, 0.0), self.seconds), 0.0

    def step(self, by: float) -> None:
        """Pause, and go on or back by so many seconds."""
        self.playing = False
        self.seek(self.time + by)

    def toggle(self) -> None:
        """Play or pause; from the end, where nothing repeats, it begins again."""
        self.playing = not self.playing
        if self.playing and self.time >= self.seconds and not self.looping:
            self.seek(0.0)

    def lasts(self, seconds: float) -> None:
        """Take another end, s; a time beyond it becomes it."""
        self.seconds = max(0.0, seconds)
        self.time = min(self.time, self.seconds)
